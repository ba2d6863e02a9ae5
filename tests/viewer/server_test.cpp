// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The answers that browsers get, over real sockets.
#include "apps/viewer/server.h"

#include <set>

#include "panoptic/base/image_io.h"
#include "tests/viewer/decoded.h"
#include "tests/viewer/server_fixture.h"

namespace panoptic {
namespace {

using test::Browser;
using test::decoded;
using test::error_of;
using test::fetch;
using test::HttpAnswer;
using test::port_of;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

class Server : public test::Served {
 protected:
  static void SetUpTestSuite() {
    idle() = std::make_unique<test::WaitingBrowser>("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  static void TearDownTestSuite() { idle().reset(); }
  static std::unique_ptr<test::WaitingBrowser>& idle() {
    static std::unique_ptr<test::WaitingBrowser> one;
    return one;
  }

  std::string keys(const Json& state) const {
    std::string joined;
    for (const Json& chunk : state["chunks"]) joined += (joined.empty() ? "" : ",") + chunk[0].get<std::string>();
    return joined;
  }
};

TEST_F(Server, TheSceneSaysWhatStaysTheSame) {
  const Json scene = json("/api/scene");
  EXPECT_EQ(scene["protocol"], 2);
  EXPECT_EQ(scene["title"], "small");
  EXPECT_FLOAT_EQ(scene["block_size_m"].get<float>(), world_.map().voxels.block_size_m());
  EXPECT_EQ(scene["first_thing"], 3);
  EXPECT_EQ(scene["has_confidence"], true);
  EXPECT_EQ(scene["classes"][1], Json::parse(R"({"id": 2, "name": "swivel chair", "is_thing": true, "color": [31, 119, 180]})"));
  EXPECT_EQ(scene["run"], json("/api/scene")["run"]);
}

TEST_F(Server, ABrowserGetsTheWholeSurfaceAndThenOnlyWhatIsNew) {
  const Json state = json("/api/state");
  EXPECT_EQ(state["revision"], 1);
  EXPECT_EQ(state["path"].size(), 2U);
  EXPECT_EQ(state["frame"]["world_from_camera"].size(), 16U);
  EXPECT_EQ(state["run"]["stages"]["fusion"]["count"], 10);
  const auto chunks = decoded(get("/api/chunks?k=" + keys(state)).body);
  ASSERT_EQ(chunks.size(), state["chunks"].size());
  std::size_t triangles = 0;
  for (const auto& chunk : chunks) triangles += chunk.triangles.size();
  EXPECT_EQ(triangles, world_.mesher().assemble(world_.map()).triangles.size());

  EXPECT_TRUE(json("/api/state?since=1")["chunks"].empty());
  world_.replace(0, std::make_shared<const MeshChunk>());
  latest_.publish(world_.snapshot());
  const Json next = json("/api/state?since=1");
  EXPECT_EQ(next["revision"], 2);
  EXPECT_FALSE(next["chunks"].empty());
  EXPECT_LT(next["chunks"].size(), state["chunks"].size()) << "the lost chunk and its neighbours, not everything";
  bool is_told = false;
  for (const auto& chunk : decoded(get("/api/chunks?k=" + keys(next)).body)) {
    EXPECT_EQ(chunk.version, 2U);
    is_told |= chunk.triangles.empty() && chunk.block == world_.map().voxels.index_of(0);
  }
  EXPECT_TRUE(is_told) << "a chunk that lost its surface comes empty";
}

TEST_F(Server, ObjectsComeWithNamesColoursAndProbabilities) {
  const Json objects = json("/api/objects");
  ASSERT_EQ(objects["objects"].size(), 1U);
  const Json& ball = objects["objects"][0];
  EXPECT_EQ(ball["name"], "swivel_chair_3000000003");
  EXPECT_EQ(ball["probabilities"], Json::parse("[[1, 0.25], [2, 0.75]]"));
  EXPECT_EQ(ball["max_m"], Json::parse("[1.0, 2.0, 3.0]"));
  const Rgb color = color_of(test::kBallId, test::small_labels());
  EXPECT_EQ(ball["color"], Json({color.r, color.g, color.b}));
}

TEST_F(Server, TheNewestFrameIsShownWithItsLabels) {
  const auto bytes_of = [](const HttpAnswer& a) { return std::vector<std::uint8_t>(a.body.begin(), a.body.end()); };
  for (const char* name : {"/api/frame.jpg", "/api/labelled.jpg"}) {
    const HttpAnswer jpeg = get(name);
    EXPECT_EQ(jpeg.headers.at("Content-Type"), "image/jpeg");
    const Image<Rgb> image = decode_rgb(bytes_of(jpeg), name);
    ASSERT_TRUE(image.same_size(4, 2));
    EXPECT_NEAR(image(0, 0).r, 200, 8);
  }
  const HttpAnswer png = get("/api/overlay.png");
  EXPECT_EQ(png.headers.at("Content-Type"), "image/png");
  EXPECT_EQ(static_cast<unsigned char>(png.body.at(25)), 6) << "colour with alpha";
  const Image<Rgb> overlay = decode_rgb(bytes_of(png), "overlay.png");
  EXPECT_EQ(overlay(1, 0), color_of(test::kBallId, test::small_labels()));
  EXPECT_EQ(overlay(0, 0), Rgb{});
  EXPECT_EQ(overlay(2, 0), Rgb{});

  auto without = world_.snapshot();
  without->frame = {};
  latest_.publish(without);
  for (const char* name : {"/api/frame.jpg", "/api/labelled.jpg", "/api/overlay.png"}) EXPECT_EQ(get(name).status, 404) << name;
  EXPECT_TRUE(json("/api/state")["frame"].is_null());
}

TEST_F(Server, TheSceneCanBeDownloadedAsGlb) {
  const HttpAnswer glb = get("/api/scene.glb");
  EXPECT_EQ(glb.headers.at("Content-Type"), "model/gltf-binary");
  EXPECT_THAT(glb.headers.at("Content-Disposition"), HasSubstr("scene.glb"));
  EXPECT_THAT(glb.body, StartsWith("glTF"));
  EXPECT_THAT(glb.body, AllOf(HasSubstr("swivel_chair_3"), HasSubstr("\"floor\"")));
}

TEST_F(Server, ThePageOrAPlainSentenceIsAtTheRoot) {
  const HttpAnswer page = get("/");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.headers.at("Content-Type"), "text/html; charset=utf-8");
  EXPECT_THAT(page.body, HasSubstr("<title>"));
  const HttpAnswer zipped = get("/", "Accept-Encoding: gzip, br\r\n");
  EXPECT_EQ(zipped.body.starts_with("\x1f\x8b"), zipped.headers.contains("Content-Encoding"));
}

TEST_F(Server, EveryAnswerForbidsWhatThePageDoesNotNeed) {
  for (const char* target : {"/", "/api/scene", "/nothing"}) {
    const HttpAnswer answer = get(target);
    EXPECT_THAT(answer.headers.at("Content-Security-Policy"),
                AllOf(HasSubstr("default-src 'none'"), HasSubstr("frame-ancestors 'none'")));
    EXPECT_EQ(answer.headers.at("X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(answer.headers.at("Referrer-Policy"), "no-referrer");
    EXPECT_EQ(answer.headers.at("Cross-Origin-Resource-Policy"), "same-origin");
  }
  EXPECT_EQ(get("/api/scene").headers.at("Cache-Control"), "no-store");
  EXPECT_EQ(get("/api/scene", "Accept-Encoding: br, gzip\r\n").headers.count("Content-Encoding"), 0U) << "no time for that";
}

TEST_F(Server, EventsTellOfEachRevisionSoon) {
  Browser browser(port_);
  browser.ask("/events", "Accept: text/event-stream\r\n");
  ASSERT_TRUE(browser.hear("\"revision\":1"));
  EXPECT_THAT(browser.heard(),
              AllOf(HasSubstr("text/event-stream"), HasSubstr("event: state\ndata: {\"revision\":1,\"frame\":1")));
  std::this_thread::sleep_for(300ms);
  const auto published = Clock::now();
  latest_.publish(world_.snapshot());
  ASSERT_TRUE(browser.hear("\"revision\":2"));
  EXPECT_LT(Clock::now() - published, 1s);
}

TEST_F(Server, RevisionsThatComeTooFastAreSkipped) {
  Browser browser(port_);
  browser.ask("/events");
  const auto start = Clock::now();
  std::uint64_t last = 0;
  while (Clock::now() - start < 1s) {
    const auto snapshot = world_.snapshot();
    last = snapshot->revision;
    latest_.publish(snapshot);
    std::this_thread::sleep_for(5ms);
  }
  ASSERT_TRUE(browser.hear("\"revision\":" + std::to_string(last)));
  std::size_t events = 0;
  for (std::size_t at = 0; (at = browser.heard().find("event: state", at)) != std::string::npos; ++at) ++events;
  EXPECT_LE(events, 7U);
}

TEST_F(Server, SeveralBrowsersAtOnceGetTheSameBytes) {
  const std::string target = "/api/chunks?k=" + keys(json("/api/state"));
  const std::string expected = get(target).body;
  std::vector<std::thread> browsers;
  std::atomic<int> same = 0;
  for (int b = 0; b < 4; ++b) {
    browsers.emplace_back([&] {
      Browser browser(port_);
      for (int n = 0; n < 20; ++n) {
        browser.ask(target);
        same += browser.answer().body == expected ? 1 : 0;
      }
    });
  }
  for (std::thread& b : browsers) b.join();
  EXPECT_EQ(same, 80);
}

TEST_F(Server, AnUpdateWhileBrowsersFetchNeverMixesChunks) {
  std::atomic<bool> done = false;
  std::thread mapping([&] {
    for (int n = 0; n < 40; ++n) {
      latest_.publish(world_.snapshot());
      std::this_thread::sleep_for(2ms);
    }
    done = true;
  });
  std::uint64_t revision = 0;
  while (!done) {
    const Json state = json("/api/state?since=" + std::to_string(revision));
    EXPECT_GE(state["revision"].get<std::uint64_t>(), revision);
    revision = state["revision"].get<std::uint64_t>();
    const std::string wanted = keys(json("/api/state"));
    EXPECT_EQ(decoded(get("/api/chunks?k=" + wanted).body).size(), json("/api/state")["chunks"].size());
  }
  mapping.join();
}

TEST_F(Server, ARestartIsAnotherRunOnTheSamePort) {
  const Json before = json("/api/scene");
  Browser watching(port_);
  watching.ask("/events");
  ASSERT_TRUE(watching.hear("event: state"));
  const std::uint16_t port = port_;
  server_.reset();
  EXPECT_TRUE(watching.is_ended(1s));
  EXPECT_FALSE(Browser(port).connected());
  start({.port = port});
  EXPECT_EQ(port_, port);
  EXPECT_NE(json("/api/scene")["run"], before["run"]);
}

TEST_F(Server, EndsPromptlyWhateverIsOpen) {
  std::vector<std::unique_ptr<Browser>> browsers;
  for (int n = 0; n < 12; ++n) {
    browsers.push_back(std::make_unique<Browser>(port_));
    if (n % 3 == 0) browsers.back()->ask("/events");
    if (n % 3 == 1) browsers.back()->say("GET / HT");
  }
  ASSERT_TRUE(browsers[0]->hear("event: state"));
  const auto start = Clock::now();
  server_.reset();
  EXPECT_LT(Clock::now() - start, 1s);
}

TEST_F(Server, ATakenPortIsOneClearLine) {
  const std::string taken = error_of([&] { ViewerServer({.port = port_}, world_.scene(), latest_); });
  EXPECT_THAT(taken, AllOf(HasSubstr(std::to_string(port_)), HasSubstr("--port")));
  EXPECT_THAT(error_of([&] { ViewerServer({.bind = "192.0.2.1", .port = 0, .token = "secret12"}, world_.scene(), latest_); }),
              HasSubstr("192.0.2.1"));
}

TEST_F(Server, WithoutAWishTheNextFreePortIsTaken) {
  const ViewerServer first({}, world_.scene(), latest_);
  const ViewerServer second({}, world_.scene(), latest_);
  EXPECT_GE(port_of(first), kDefaultViewerPort);
  EXPECT_GT(port_of(second), port_of(first));
  EXPECT_EQ(fetch(port_of(second), "/api/scene").status, 200);
}

TEST_F(Server, AForgottenSnapshotIsFreedAfterTheLastBrowser) {
  std::weak_ptr<const Snapshot> old = latest_.newest();
  {
    Browser browser(port_);
    browser.ask("/events");
    ASSERT_TRUE(browser.hear("event: state"));
    EXPECT_EQ(get("/api/state").status, 200);
    latest_.publish(world_.snapshot());
    EXPECT_FALSE(old.expired());
  }
  const auto until = Clock::now() + 3s;
  while (!old.expired() && Clock::now() < until) std::this_thread::sleep_for(10ms);
  EXPECT_TRUE(old.expired());
}

// Last, since it waits from the first test on.
TEST_F(Server, EventsHoldASignOfLifeWhileNothingHappens) { EXPECT_TRUE(idle()->browser->hear(": still here", 5s)); }

}  // namespace
}  // namespace panoptic
