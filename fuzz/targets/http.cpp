// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

#include "apps/viewer/access.h"
#include "apps/viewer/connection.h"
#include "apps/viewer/content.h"
#include "apps/viewer/server.h"
#include "fuzz/input.h"
#include "fuzz/small_map.h"

namespace panoptic::fuzz {
namespace {

constexpr std::string_view kToken = "s3cret-token";

std::shared_ptr<const Snapshot> small_snapshot() {
  const PanopticMap map = small_map();
  Mesher mesher{MesherOptions{}};
  mesher.update(map);
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->revision = 3;
  for (Slot slot = 0; slot < map.voxels.block_count(); ++slot) {
    snapshot->chunks.push_back({map.voxels.index_of(slot), 1, mesher.chunks()[slot]});
  }
  SnapshotObject chair;
  chair.id = static_cast<PanopticId>(small_labels().first_thing());
  chair.class_id = ClassId{2};
  chair.probabilities = {{ClassId{2}, 0.5F}};
  snapshot->objects = {chair};
  snapshot->frame.index = 3;
  snapshot->frame.color_camera = {4, 2, 3, 3, 1.5, 0.5};
  snapshot->frame.color = std::make_shared<const SharedImage<Rgb>>(Image<Rgb>(4, 2, Rgb{200, 100, 50}));
  return snapshot;
}

SnapshotScene small_scene() { return {"small", "made for a fuzzer", small_labels(), 0.024F, 0.024F * kBlockSide}; }

const LatestSnapshot& latest() {
  static const std::unique_ptr<LatestSnapshot> kLatest = [] {
    auto latest = std::make_unique<LatestSnapshot>();
    latest->publish(small_snapshot());
    return latest;
  }();
  return *kLatest;
}

// Fuzzes the code that takes requests apart before the library sees them, and the code that decides on access.
void heads(std::string_view text) {
  constexpr std::size_t kMostHeaders = 64;
  const RequestHead head = checked_head(text, kMostHeaders);
  require(head.status == 200 || (head.status >= 400 && head.status <= 505 && head.text.empty()), "a head is taken or refused");
  require(head.status != 200 || head.text.ends_with("\r\n\r\n"), "a head that is taken is complete");
  require(refusal(head.status).starts_with("HTTP/1.1 "), "a refusal is an answer");
  names_loopback(text);
  is_loopback(text);
  require(!is_same_secret(text, kToken) || text == kToken, "only the token is the token");
  const std::string_view cookie = cookie_value(text, "panoptic_1");
  require(cookie.empty() || (cookie.data() >= text.data() && cookie.data() + cookie.size() <= text.data() + text.size()),
          "a cookie is a part of its header");
  if (is_well_formed_token(text)) require(text.find_first_of("\r\n \";,") == std::string_view::npos, "tokens need no escape");
}

// "path?name=value&name=value", taken apart without escapes.
void content(std::string_view text) {
  static ViewerContent viewer(small_scene(), latest());
  const std::size_t mark = text.find('?');
  const std::string path(text.substr(0, mark));
  Query query;
  for (std::string_view rest = mark == std::string_view::npos ? "" : text.substr(mark + 1); !rest.empty();) {
    const std::string_view pair = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
    const std::size_t equals = pair.find('=');
    query.emplace(pair.substr(0, equals), equals == std::string_view::npos ? "" : pair.substr(equals + 1));
  }
  const Answer answer = viewer.answer(path, query);
  require(answer.body != nullptr && answer.status >= 200 && answer.status <= 503, "there is an answer");
}

std::uint16_t port_of(const ViewerServer& server) {
  const std::string url = server.url();
  return static_cast<std::uint16_t>(std::stoi(url.substr(url.find(':', 7) + 1)));
}

// Sends everything, ends its side and reads until the other side ends.
std::string talk(std::uint16_t port, std::string_view text) {
  const int browser = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  // From another loopback address each time: closed connections wait for late packets and keep their ports meanwhile.
  static std::uint32_t next = 0;
  next = (next + 1) % 0xFFFFFD;
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK + next);
  require(::bind(browser, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0, "every loopback address is ours");
  const timeval patience{5, 0};
  ::setsockopt(browser, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int connected = ::connect(browser, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  if (connected != 0 && errno == EINTR) {  // the fuzzer's clock; the connection is being made nevertheless
    pollfd ready{browser, POLLOUT, 0};
    while (::poll(&ready, 1, 5000) < 0 && errno == EINTR) continue;
  } else if (connected != 0) {
    require(false, std::strerror(errno));
  }
  while (!text.empty()) {
    const ssize_t sent = ::send(browser, text.data(), text.size(), MSG_NOSIGNAL);
    if (sent <= 0) break;
    text.remove_prefix(static_cast<std::size_t>(sent));
  }
  ::shutdown(browser, SHUT_WR);
  std::string answer;
  std::array<char, 16384> buffer{};
  ssize_t got = 0;
  while ((got = ::recv(browser, buffer.data(), buffer.size(), 0)) > 0 || (got < 0 && errno == EINTR)) {
    answer.append(buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  }
  require(got == 0 || errno != EAGAIN, "the server answers or ends the connection");
  ::close(browser);
  return answer;
}

void server(std::string_view text, bool has_token) {
  static ViewerServer open({.port = 0}, small_scene(), latest());
  static ViewerServer guarded({.port = 0, .token = std::string(kToken)}, small_scene(), latest());
  const std::string answer = talk(port_of(has_token ? guarded : open), text);
  require(answer.empty() || answer.starts_with("HTTP/1.1 "), "an answer is HTTP");
  const bool is_let_in = answer.find("HTTP/1.1 200") != std::string::npos;
  require(!is_let_in || !has_token || text.find("token") != std::string_view::npos, "without the token nobody gets in");
}

}  // namespace

// The first byte says who gets the rest.
void http(Input input) {
  if (input.empty()) return;
  const std::string_view text = text_of(input.subspan(1));
  switch (input[0] % 4) {
    case 0:
      return heads(text);
    case 1:
      return content(text);
    default:
      return server(text, input[0] % 4 == 2);
  }
}

}  // namespace panoptic::fuzz
