// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The server refuses what it does for nobody, and stays well whatever it is sent.
#include <random>

#include "tests/fresh_seed.h"
#include "tests/viewer/decoded.h"
#include "tests/viewer/server_fixture.h"

namespace panoptic {
namespace {

using test::Browser;
using test::error_of;
using test::HttpAnswer;
using test::tell;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

class ServerRefuses : public test::Served {
 protected:
  static void SetUpTestSuite() { half_told() = std::make_unique<test::WaitingBrowser>("GET /api/scene HTTP/1.1\r\nHost: local"); }
  static void TearDownTestSuite() { half_told().reset(); }
  static std::unique_ptr<test::WaitingBrowser>& half_told() {
    static std::unique_ptr<test::WaitingBrowser> one;
    return one;
  }

  // The server answers others as ever.
  void expect_well() const { EXPECT_EQ(json("/api/state")["revision"], latest_.newest()->revision); }
};

TEST_F(ServerRefuses, PathsThatAreNotInItsTable) {
  for (const char* target : {"/api",
                             "/api/",
                             "/api/scene/",
                             "/API/scene",
                             "//api/scene",
                             "/api//scene",
                             "/assets/",
                             "/assets/../../etc/passwd",
                             "/../etc/passwd",
                             "/%2e%2e/%2e%2e/etc/passwd",
                             "/..%2f..%2fetc%2fpasswd",
                             "/api/scene%00.jpg",
                             "/%",
                             "/%zz",
                             "/etc/passwd",
                             "/index.html%00",
                             "/api/../api/scene",
                             "/\\..\\etc",
                             "/events/",
                             "/%ff%fe"}) {
    const HttpAnswer answer = get(target);
    EXPECT_EQ(answer.status, 404) << target;
    EXPECT_THAT(answer.body, Not(HasSubstr("root:"))) << target;
  }
  expect_well();
}

TEST_F(ServerRefuses, QueriesThatAreNotAsDocumented) {
  for (const char* target :
       {"/api/state?since=", "/api/state?since=-1", "/api/state?since=1x", "/api/state?since=99999999999999999999999",
        "/api/chunks", "/api/chunks?k=", "/api/chunks?k=1,2", "/api/chunks?k=1,2,3,", "/api/chunks?k=a,b,c",
        "/api/chunks?k=1,2,99999999999", "/api/chunks?k=,,", "/api/chunks?k=1;2;3", "/api/chunks?k=0x1,2,3"}) {
    EXPECT_EQ(get(target).status, 400) << target;
  }
  std::string keys = "0,0,0";
  for (int n = 1; n < 64; ++n) keys += ",0,0,0";
  EXPECT_EQ(get("/api/chunks?k=" + keys).status, 200);
  EXPECT_EQ(get("/api/chunks?k=" + keys + ",0,0,0").status, 400);
  expect_well();
}

TEST_F(ServerRefuses, NothingForChunksThatDoNotExist) {
  for (const char* target :
       {"/api/chunks?k=9999,0,0", "/api/chunks?k=2147483647,-2147483648,0,1048576,0,0", "/api/chunks?k=-5,-5,-5"}) {
    const HttpAnswer answer = get(target);
    EXPECT_EQ(answer.status, 200) << target;
    EXPECT_TRUE(test::decoded(answer.body).empty()) << target;
  }
  EXPECT_EQ(test::decoded(get("/api/chunks?k=0,0,0,9999,0,0").body).size(), 1U) << "those that do exist come all the same";
  expect_well();
}

TEST_F(ServerRefuses, HugeRequests) {
  EXPECT_EQ(tell(port_, "GET /" + std::string(20000, 'a') + " HTTP/1.1\r\n\r\n").status, 431);
  EXPECT_EQ(tell(port_, "GET / HTTP/1.1\r\nCookie: " + std::string(20000, 'a') + "\r\n\r\n").status, 431);
  EXPECT_EQ(tell(port_, std::string(100000, 'a')).status, 431) << "no end of line at all";
  std::string many = "GET / HTTP/1.1\r\n";
  for (int n = 0; n < 200; ++n) many += "X-" + std::to_string(n) + ": y\r\n";
  EXPECT_EQ(tell(port_, many + "\r\n").status, 431);
  EXPECT_EQ(get("/" + std::string(12000, 'a')).status, 414) << "the head is allowed, such a name is not";
  EXPECT_EQ(get("/", "Range: bytes=0-1" + std::string(7000, ',') + "\r\n").status, 200) << "ranges are not looked at";
  std::string parameters = "/api/state?a=1";
  for (int n = 0; n < 1500; ++n) parameters += "&b=" + std::to_string(n % 10);
  EXPECT_EQ(get(parameters).status, 200);
  expect_well();
}

TEST_F(ServerRefuses, BodiesAndMethodsThatChangeThings) {
  const std::string host = " / HTTP/1.1\r\nHost: localhost\r\n";
  for (const char* method : {"POST", "PUT", "DELETE", "PATCH", "OPTIONS", "CONNECT", "TRACE", "PRI"}) {
    EXPECT_EQ(tell(port_, method + host + "\r\n").status, 405) << method;
  }
  EXPECT_EQ(tell(port_, "GET" + host + "Content-Length: 1000000000000\r\n\r\n").status, 413);
  EXPECT_EQ(tell(port_, "GET" + host + "Transfer-Encoding: chunked\r\n\r\n").status, 413);
  EXPECT_EQ(tell(port_, "nonsense\r\n\r\n").status, 400);
  expect_well();
}

TEST_F(ServerRefuses, HostsThatAreNotThisMachine) {
  const auto with_host = [&](const std::string& host) {
    return tell(port_, "GET /api/scene HTTP/1.1\r\n" + host + "\r\n").status;
  };
  EXPECT_EQ(with_host("Host: rebound.example.org\r\n"), 403);
  EXPECT_EQ(with_host("Host: 127.0.0.1.example.org:8060\r\n"), 403);
  EXPECT_EQ(with_host(""), 403);
  EXPECT_EQ(with_host("Host: localhost:1234\r\n"), 200);
  EXPECT_EQ(with_host("Host: [::1]\r\n"), 200);
  EXPECT_EQ(with_host("Host: localhost\r\nSec-Fetch-Site: cross-site\r\n"), 403) << "pages from elsewhere";
  EXPECT_EQ(with_host("Host: localhost\r\nSec-Fetch-Site: same-origin\r\n"), 200);
}

TEST_F(ServerRefuses, WhoeverDoesNotShowTheToken) {
  start({.bind = "0.0.0.0", .port = 0, .token = "a-secret.of~mine"});
  EXPECT_THAT(server_->url(), HasSubstr("?token=a-secret.of~mine"));
  for (const char* target : {"/", "/api/scene", "/events", "/api/scene?token=", "/api/scene?token=a-secret.of~min", "/nothing",
                             "/api/scene?token=A-secret.of~mine", "/api/scene?Token=a-secret.of~mine"}) {
    EXPECT_EQ(get(target).status, 401) << target;
    EXPECT_EQ(get(target, "Cookie: panoptic_1=a-secret.of~mine\r\n").status, 401) << target;
  }
  const HttpAnswer first = get("/?token=a-secret.of~mine");
  EXPECT_EQ(first.status, 200);
  const std::string cookie = first.headers.at("Set-Cookie");
  EXPECT_THAT(cookie, AllOf(HasSubstr("HttpOnly"), HasSubstr("SameSite=Strict")));
  const std::string shown = "Cookie: theme=dark; " + cookie.substr(0, cookie.find(';')) + "\r\n";
  EXPECT_EQ(get("/api/scene", shown).status, 200);
  EXPECT_EQ(get("/api/scene", shown).headers.count("Set-Cookie"), 0U);
  EXPECT_EQ(get("/api/scene", "Cookie: " + cookie.substr(0, cookie.find('=')) + "=wrong\r\n").status, 401);
}

TEST_F(ServerRefuses, ToListenToOthersWithoutAToken) {
  for (const char* bind : {"0.0.0.0", "::", "192.168.0.1"}) {
    EXPECT_THAT(error_of([&] { ViewerServer({.bind = bind, .port = 0}, world_.scene(), latest_); }), HasSubstr("--token"));
  }
  EXPECT_THAT(error_of([&] { ViewerServer({.port = 0, .token = "short"}, world_.scene(), latest_); }), HasSubstr("8 to 128"));
}

TEST_F(ServerRefuses, TheSeventeenthWatcherUntilAnotherLeaves) {
  std::vector<std::unique_ptr<Browser>> watchers;
  for (int n = 0; n < 16; ++n) {
    watchers.push_back(std::make_unique<Browser>(port_));
    watchers.back()->ask("/events");
    ASSERT_TRUE(watchers.back()->hear("event: state")) << n;
  }
  EXPECT_EQ(get("/events").status, 503);
  expect_well();
  watchers[3]->leave();
  bool admitted = false;
  for (const auto until = Clock::now() + 2s; !admitted && Clock::now() < until;) {
    Browser next(port_);
    next.ask("/events");
    admitted = next.hear("event: state", 200ms);
  }
  EXPECT_TRUE(admitted) << "it is noticed soon when a browser leaves";
}

TEST_F(ServerRefuses, ToLetSilentConnectionsKeepOthersOut) {
  std::vector<std::unique_ptr<Browser>> silent;
  for (int n = 0; n < 40; ++n) {
    silent.push_back(std::make_unique<Browser>(port_));
    silent.back()->say(n % 2 == 0 ? "GET /api/st" : "");
  }
  const auto start = Clock::now();
  expect_well();
  EXPECT_LT(Clock::now() - start, 1s);
  for (int n = 40; n < 80; ++n) silent.push_back(std::make_unique<Browser>(port_));
  EXPECT_EQ(silent.back()->answer().status, 503) << "more than it has room for";
  silent.clear();
  int status = 503;
  for (const auto until = Clock::now() + 2s; status == 503 && Clock::now() < until;) status = get("/api/scene").status;
  EXPECT_EQ(status, 200);
}

TEST_F(ServerRefuses, ToBeSlowedByBrowsersThatDoNotReadOrVanish) {
  std::vector<std::unique_ptr<Browser>> rude;
  for (int n = 0; n < 8; ++n) {
    rude.push_back(std::make_unique<Browser>(port_));
    for (int more = 0; more < 200; ++more) rude.back()->ask("/api/state");
    rude.push_back(std::make_unique<Browser>(port_));
    rude.back()->ask("/events");
    if (n % 2 == 0) rude.back()->leave();
    Browser vanishing(port_);
    vanishing.ask("/api/scene.glb");
  }
  const auto start = Clock::now();
  for (int n = 0; n < 100; ++n) latest_.publish(world_.snapshot());
  EXPECT_LT(Clock::now() - start, 1s) << "mapping goes on";
  expect_well();
}

TEST_F(ServerRefuses, ToFallOverRandomBytes) {
  std::mt19937_64 random(test::fresh_seed());
  const std::string alphabet = "GET /api/chunks?k=,-%&=0123456789 HTTP/1.1\r\nHost: \r\n\r\nRange: bytes=\t\xff";
  for (int n = 0; n < 120; ++n) {
    std::string bytes = n % 3 == 0 ? "" : "GET /api/";
    for (std::uint64_t i = random() % 400; i > 0; --i) {
      bytes += n % 2 == 0 ? static_cast<char>(random() % 256) : alphabet[random() % alphabet.size()];
    }
    if (n % 3 == 1) bytes += " HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
    if (n % 3 == 2) bytes += "\r\n\r\n";
    Browser browser(port_);
    browser.say(bytes);
    if (n % 4 != 0) browser.hear("\r\n\r\n", 20ms);
  }
  expect_well();
}

// Last, since it waits from the first test on.
TEST_F(ServerRefuses, ToWaitForAnHalfToldRequest) {
  EXPECT_EQ(half_told()->browser->answer().status, 408);
  EXPECT_TRUE(half_told()->browser->is_ended(1s));
}

}  // namespace
}  // namespace panoptic
