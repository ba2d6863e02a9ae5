// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A viewer of the small world on a free port, and browsers for it.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "apps/viewer/server.h"
#include "panoptic/base/json.h"
#include "tests/expect_error.h"
#include "tests/viewer/browser.h"
#include "tests/viewer/small_world.h"

namespace panoptic::test {

inline std::uint16_t port_of(const ViewerServer& server) {
  const std::string url = server.url();
  return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
}

class Served : public testing::Test {
 protected:
  Served() {
    latest_.publish(world_.snapshot());
    start();
  }

  void start(const ViewerOptions& options = {.port = 0}) {
    server_ = std::make_unique<ViewerServer>(options, world_.scene(), latest_);
    port_ = port_of(*server_);
  }
  HttpAnswer get(const std::string& target, const std::string& headers = "") const { return fetch(port_, target, headers); }
  Json json(const std::string& target) const {
    const HttpAnswer answer = get(target);
    EXPECT_EQ(answer.status, 200) << target;
    return Json::parse(answer.body);
  }

  SmallWorld world_;
  LatestSnapshot latest_;
  std::unique_ptr<ViewerServer> server_;
  std::uint16_t port_ = 0;
};

// A server of its own, and a browser that has told it something and waits for seconds, while the other tests of a suite run.
struct WaitingBrowser {
  explicit WaitingBrowser(const std::string& told) {
    latest.publish(world.snapshot());
    server = std::make_unique<ViewerServer>(ViewerOptions{.port = 0}, world.scene(), latest);
    browser = std::make_unique<Browser>(port_of(*server));
    browser->say(told);
  }

  SmallWorld world;
  LatestSnapshot latest;
  std::unique_ptr<ViewerServer> server;
  std::unique_ptr<Browser> browser;
};

}  // namespace panoptic::test
