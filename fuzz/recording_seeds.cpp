// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "fuzz/seeds.h"

namespace panoptic::fuzz {
namespace {

std::string pose_text() { return "1 0 0 0.5\n0 1 0 -1.5\n0 0 1 2\n0 0 0 1\n"; }
std::string line(std::string text) {
  for (char& c : text) c = c == '\n' ? ' ' : c;
  return text + "\n";
}

void folder_seeds(Seeds& seeds) {
  const std::string intrinsic = "7 0 3.5 0\n0 7 2.5 0\n0 0 1 0\n0 0 0 1\n";
  const std::string identity = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  const std::string info = fmt::format(
      "m_versionNumber = 4\nm_colorWidth = 8\nm_colorHeight = 6\nm_depthWidth = 8\nm_depthHeight = 6\nm_depthShift = 1000\n"
      "m_calibrationColorIntrinsic = {0}m_calibrationColorExtrinsic = {1}m_calibrationDepthIntrinsic = {0}"
      "m_calibrationDepthExtrinsic = {1}",
      line(intrinsic), line(identity));
  const std::string poses = "# time tx ty tz qx qy qz qw\n1000.0 1 2 3 0 0 0 1\n1001.0 1 2 4 0 0.6 0 0.8\n";
  seeds.put("recording", "scannet", {pose_text(), pose_text(), intrinsic, intrinsic, identity, identity}, 0);
  seeds.put("recording", "scannet_cpp", {info, pose_text()}, 1);
  seeds.put("recording", "seven_scenes", {"7 0 3.5\n0 7 2.5\n0 0 1\n", pose_text(), pose_text()}, 2);
  seeds.put("recording", "tum",
            {"# rgb\n1000.01 rgb/0.png\n1001.01 rgb/1.png\n", "1000.0 depth/0.png\n1001.0 depth/1.png\n", poses}, 3);
  seeds.put("recording", "icl", {"1000 depth/0.png 1000 rgb/0.png\n1001 depth/1.png 1001 rgb/1.png\n", poses}, 4);
  seeds.put("recording", "replica",
            {line(pose_text()) + line(pose_text()),
             R"({"camera": {"w": 8, "h": 6, "fx": 7, "fy": 7, "cx": 3.5, "cy": 2.5, "scale": 6553.5}})"},
            5);
  seeds.put("recording", "plain", {"7 0 3.5\n0 7 2.5\n0 0 1\n", line(pose_text()) + line(pose_text())}, 6);
  seeds.put("recording", "named", {"7 7 3.5 2.5\n", "0.png 1 2 3 0 0 0 1\n1.png 1 2 4 0 0.6 0 0.8\n"}, 6);
  seeds.put("recording", "decimal_commas", {"[[7 0 3,5]\n[0 7 2,5]\n[0 0 1]]\n", "1,5 2 3 0 0,6 0 0,8\n1 2 4 0 0,6 0 0,8\n"}, 6);
  const std::string camera = R"({"width": 8, "height": 6, "intrinsic_matrix": [7, 0, 0, 0, 7, 0, 3.5, 2.5, 1]})";
  seeds.put("recording", "open3d", {camera, "0 0 2\n" + pose_text() + "1 1 2\n" + pose_text()}, 7);
  const std::string three_rows = "1 0 0 0.5\n0 1 0 -1.5\n0 0 1 2\n";
  seeds.put("recording", "sun3d", {"7 0 3.5\n0 7 2.5\n0 0 1\n", three_rows + three_rows}, 8);
  seeds.put("recording", "flat", {intrinsic, pose_text(), pose_text()}, 9);
}

// Recordings of phones and of their tools.
void phone_seeds(Seeds& seeds) {
  const std::string pincam = "8 6 7 7 3.5 2.5\n";
  seeds.put("recording", "arkitscenes", {"1.0 0 0.1 0 1 2 3\n1.1 0 0.2 0 1 2 4\n", pincam, pincam}, 10);
  const std::string matrix = "7,0,3.5\n0,7,2.5\n0,0,1\n";
  seeds.put("recording", "stray",
            {"timestamp, frame, x, y, z, qx, qy, qz, qw\n1.0, 0, 1, 2, 3, 0, 0, 0, 1\n1.1, 1, 1, 2, 4, 0, 0.6, 0, 0.8\n", matrix},
            11);
  seeds.put("recording", "stray_rows",
            {"timestamp,frame,x,y,z,qx,qy,qz,qw,fx,fy,cx,cy\n1,0,1,2,3,0,0,0,1,7,7,3.5,2.5\n2,1,1,2,4,0,0.6,0,0.8,7,7,3.5,2.5\n",
             matrix},
            11);
  seeds.put("recording", "record3d",
            {R"({"w": 8, "h": 6, "fps": 60, "K": [7, 0, 0, 0, 7, 0, 3.5, 2.5, 1], "poses": [[0, 0, 0, 1, 1, 2, 3],
[0, 0.6, 0, 0.8, 1, 2, 4]], "perFrameIntrinsicCoeffs": [[7, 7, 3.5, 2.5], [7, 7, 3.5, 2.5]], "frameTimestamps": [1, 1.1]})"},
            12);
  const std::string yaml =
      "%YAML:1.0\nimage_width: 8\nimage_height: 6\ncamera_matrix:\n   rows: 3\n   cols: 3\n   data: [ 7., 0., 3.5, 0., 7., 2.5, "
      "0., 0., 1. "
      "]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n   data: [ 0., 0., 0., 0., 0. ]\nlocal_transform:\n   data: [ "
      "0., 0., 1., "
      "0., -1., 0., 0., 0., 0., -1., 0., 0. ]\n";
  const std::string stamped = "1.0 1 2 3 0 0 0 1 1\n1.1 1 2 4 0 0.6 0 0.8 2\n";
  seeds.put("recording", "rtabmap", {yaml, yaml, stamped}, 13);
  seeds.put("recording", "rtabmap_robot", {yaml, yaml, "", stamped}, 13);
  const std::string sizes = "m_colorWidth = 8\nm_colorHeight = 6\nm_depthWidth = 8\nm_depthHeight = 6\nm_depthShift = 1000\n";
  const std::string square = "7 0 3.5 0 0 7 2.5 0 0 0 1 0 0 0 0 1\n";
  const std::string unit = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n";
  seeds.put("recording", "bundle_fusion",
            {sizes + "m_calibrationColorIntrinsic = " + square + "m_calibrationColorExtrinsic = " + unit +
                 "m_calibrationDepthIntrinsic = " + square + "m_calibrationDepthExtrinsic = " + unit,
             pose_text(), pose_text()},
            14);
}

}  // namespace

void recording_seeds(Seeds& seeds) {
  folder_seeds(seeds);
  phone_seeds(seeds);
}

}  // namespace panoptic::fuzz
