// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/connection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <random>
#include <thread>

#include "panoptic/base/config.h"

namespace panoptic {
namespace {

using testing::HasSubstr;
using testing::Not;
using namespace std::chrono_literals;

int status_of(const std::string& head) { return checked_head(head, 64).status; }

TEST(CheckedHead, TakesPlainRequestsAndLeavesOutWhatIsNotUsed) {
  const RequestHead head = checked_head(
      "GET /api/state?since=3 HTTP/1.1\r\nHost: localhost:1\r\nRange: bytes=0-1,2-3\r\nExpect: 100-continue\r\n"
      "ACCEPT-encoding: br, gzip\r\nX-Accepts-Gzip: 1\r\nContent-Length: 0\r\ncookie:  a=b \r\n\r\n",
      64);
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.text, "GET /api/state?since=3 HTTP/1.1\r\nHost: localhost:1\r\ncookie: a=b\r\n\r\n");
  EXPECT_TRUE(head.accepts_gzip);
  EXPECT_FALSE(head.is_event_stream);
  EXPECT_TRUE(checked_head("GET /events HTTP/1.1\r\n\r\n", 64).is_event_stream);
}

TEST(CheckedHead, RefusesWhatIsNoPlainGet) {
  EXPECT_EQ(status_of("HEAD / HTTP/1.0\r\n\r\n"), 200);
  EXPECT_EQ(status_of("POST / HTTP/1.1\r\n\r\n"), 405);
  EXPECT_EQ(status_of("get / HTTP/1.1\r\n\r\n"), 405);
  EXPECT_EQ(status_of("GET / HTTP/2.0\r\n\r\n"), 505);
  for (const char* line :
       {"", "GET", "GET /", "GET / HTTP/1.1 x", "GET  / HTTP/1.1", "GET example.org HTTP/1.1", "GET http://x/ HTTP/1.1",
        " GET / HTTP/1.1", "GET / FTP/1.1", "GET /\x01 HTTP/1.1", "GET / HTTP/1.1\r"}) {
    EXPECT_EQ(status_of(std::string(line) + "\r\n\r\n"), 400) << line;
  }
}

TEST(CheckedHead, RefusesNothingAtAll) {
  for (const char* text : {"", "\r\n", "\r\n\r\n"}) EXPECT_EQ(status_of(text), 400);
}

TEST(CheckedHead, RefusesBodiesAndBrokenHeaders) {
  const auto with = [](const std::string& header) { return status_of("GET / HTTP/1.1\r\n" + header + "\r\n\r\n"); };
  EXPECT_EQ(with("Content-Length: 5"), 413);
  EXPECT_EQ(with("Content-Length: -1"), 413);
  EXPECT_EQ(with("Transfer-Encoding: chunked"), 413);
  for (const char* header : {"no colon", ": no name", "na me: x", "folded: x\r\n y", "bare\nline: x", "Host : x"}) {
    EXPECT_EQ(with(header), 400) << header;
  }
  std::string many;
  for (int i = 0; i < 65; ++i) many += "X: y\r\n";
  EXPECT_EQ(with(many), 431);
}

// A connection and the browser at its other end.
class Pair {
 public:
  explicit Pair(const ConnectionLimits& limits) : Pair(sockets(), limits) {}
  ~Pair() { hang_up(); }
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;
  void say(const std::string& text) const {
    EXPECT_EQ(::send(browser_, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
  }
  void hang_up() {
    if (browser_ >= 0) ::close(browser_);
    browser_ = -1;
  }
  Connection& server() { return server_; }

 private:
  static std::array<int, 2> sockets() {
    std::array<int, 2> both{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, both.data()), 0);
    return both;
  }
  Pair(const std::array<int, 2>& both, const ConnectionLimits& limits) : browser_(both[0]), server_(both[1], limits) {}

  int browser_;
  Connection server_;
};

TEST(Connection, RequestsInOnePieceOrInManyAreReadOneByOne) {
  Pair pair({});
  pair.say("GET /a HTTP/1.1\r\n\r\nGET /b HT");
  EXPECT_THAT(pair.server().read_head().text, HasSubstr("/a"));
  std::thread slow([&] {
    for (const char* piece : {"TP/1.1\r", "\n\r", "\n"}) {
      std::this_thread::sleep_for(5ms);
      pair.say(piece);
    }
  });
  EXPECT_EQ(pair.server().read_head().text, "GET /b HTTP/1.1\r\n\r\n");
  slow.join();
  pair.hang_up();
  EXPECT_EQ(pair.server().read_head().status, 0);
  EXPECT_TRUE(pair.server().is_left());
}

TEST(Connection, PatienceEndsAtItsLimits) {
  ConnectionLimits limits;
  limits.idle = 30ms;
  limits.head = 60ms;
  Pair silent(limits);
  EXPECT_EQ(silent.server().read_head().status, 0);
  Pair half(limits);
  half.say("GET / HTTP/1.1\r\nHost:");
  EXPECT_EQ(half.server().read_head().status, 408);
  // A byte now and then does not help: the limit is for the whole head.
  Pair dripping(limits);
  dripping.say("x");
  std::thread drip([&] {
    for (int i = 0; i < 20; ++i) {
      std::this_thread::sleep_for(10ms);
      dripping.say("x");
    }
  });
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(dripping.server().read_head().status, 408);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 190ms);
  drip.join();
}

TEST(Connection, HeadsHaveALargestSize) {
  ConnectionLimits limits;
  limits.max_head_bytes = 1000;
  Pair endless(limits);
  endless.say("GET /" + std::string(2000, 'x'));
  EXPECT_EQ(endless.server().read_head().status, 431);
  Pair fitting(limits);
  const std::string head = "GET /" + std::string(1000 - 18, 'x') + " HTTP/1.1\r\n\r\n";
  ASSERT_EQ(head.size(), 1000U);
  fitting.say(head);
  EXPECT_EQ(fitting.server().read_head().status, 200);
  Pair larger(limits);
  larger.say("GET /x" + head.substr(5));
  EXPECT_EQ(larger.server().read_head().status, 431);
}

TEST(Connection, ABrowserThatDoesNotReadIsGivenUp) {
  ConnectionLimits limits;
  limits.write = 50ms;
  Pair pair(limits);
  EXPECT_TRUE(pair.server().write("hello"));
  EXPECT_FALSE(pair.server().write(std::string(std::size_t{32} << 20, 'x')));
  Pair gone(limits);
  gone.hang_up();
  EXPECT_FALSE(gone.server().write("hello"));
}

TEST(Connection, NoBytesMakeTheHeadCheckCrash) {
  std::mt19937_64 random(7);
  const std::string alphabet = "GET /HTTP1.0\r\n: \tabc\x7f\x01";
  std::array<int, 600> seen{};
  for (int n = 0; n < 20000; ++n) {
    std::string text = n % 2 == 0 ? "GET / HTTP/1.1\r\n" : "";
    for (std::uint64_t i = random() % 64; i > 0; --i) {
      text += n % 3 == 0 ? static_cast<char>(random() % 256) : alphabet[random() % alphabet.size()];
    }
    const RequestHead head = checked_head(text + "\r\n\r\n", 64);
    ++seen.at(static_cast<std::size_t>(head.status));
    EXPECT_EQ(head.text.ends_with("\r\n\r\n"), head.status == 200);
    EXPECT_EQ(head.text.empty(), head.status != 200);
  }
  EXPECT_GT(seen[200], 100);
  EXPECT_GT(seen[400], 100);
  EXPECT_THAT(refusal(431), HasSubstr("431 Request Header Fields Too Large"));
  EXPECT_THAT(refusal(400), Not(HasSubstr("Allow:")));
}

}  // namespace
}  // namespace panoptic
