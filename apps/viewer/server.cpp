// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/server.h"

#include <fmt/format.h>
#include <httplib.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <set>
#include <string_view>
#include <thread>
#include <utility>

#include "apps/viewer/access.h"
#include "apps/viewer/assets.h"
#include "apps/viewer/connection.h"
#include "apps/viewer/content.h"

namespace panoptic {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxConnections = 64;
constexpr int kMaxEventStreams = 16;
constexpr int kMaxRequestsPerConnection = 1000;
constexpr std::chrono::seconds kIdle{15};  // between two requests
constexpr int kPortsTried = 100;
constexpr std::size_t kPieceBytes = std::size_t{256} << 10;  // a browser must take one within ConnectionLimits::write
constexpr std::chrono::milliseconds kLookEvery{100};         // for new snapshots
constexpr std::chrono::milliseconds kEventEvery{250};        // at most
constexpr std::chrono::milliseconds kSignOfLifeEvery{3000};
constexpr const char* kAcceptsGzip = "X-Accepts-Gzip";  // from read_head to the handler; browsers' own headers do not get through

constexpr std::string_view kNoPage =
    "<!doctype html><title>PanopticFusion</title><p>This program was built without its page: run scripts/setup and build again. "
    "The data are there: <a href=\"/api/state\">/api/state</a>.\n";

const httplib::Headers kSecurityHeaders = {
    {"Content-Security-Policy",
     "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' data: blob:; "
     "font-src 'self' data:; connect-src 'self' data: blob:; worker-src 'self' blob:; base-uri 'none'; form-action 'none'; "
     "frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"X-Frame-Options", "DENY"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cross-Origin-Opener-Policy", "same-origin"}};

// A request whose head has been read, as the library wants to see it.
class HeadStream : public httplib::Stream {
 public:
  HeadStream(Connection& connection, const RequestHead& head) : connection_(connection), head_(head) {}

  bool is_readable() const override { return taken_ < head_.text.size(); }
  bool is_writable() const override { return !head_.is_event_stream || !connection_.is_left(); }
  ssize_t read(char* out, size_t size) override {
    const std::size_t count = head_.text.copy(out, size, taken_);
    taken_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* bytes, size_t size) override {
    return connection_.write({bytes, size}) ? static_cast<ssize_t>(size) : -1;
  }
  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    ip = "";
    port = 0;
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    ip = "";
    port = 0;
  }
  socket_t socket() const override { return 0; }  // it only looks whether the number is small

 private:
  Connection& connection_;
  const RequestHead& head_;
  std::size_t taken_ = 0;
};

// The library's server with our own handling of connections, which bounds what each may take.
class HttpServer : public httplib::Server {
 public:
  // Room for browsers that come at once: of the library's five a sixth would have to knock again after a second.
  void widen_queue() { ::listen(svr_sock_, static_cast<int>(kMaxConnections)); }

  // Ends every connection and admits no more.
  void end_connections() {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    for (const int socket : sockets_) ::shutdown(socket, SHUT_RDWR);
  }

 private:
  bool process_and_close_socket(socket_t socket) override {
    const std::size_t before = admit(socket);
    try {
      Connection connection(socket, ConnectionLimits{.idle = kIdle});
      if (before >= kMaxConnections) connection.write(refusal(503));
      if (before < kMaxConnections) serve(connection);
      leave(socket);  // before the number can belong to somebody else
    } catch (...) {   // out of memory: this browser goes, the others stay
      leave(socket);
    }
    return true;
  }

  void serve(Connection& connection) {
    for (int n = 1; n <= kMaxRequestsPerConnection; ++n) {
      const RequestHead head = connection.read_head();
      if (head.status == 0) return;
      if (head.status != 200) {
        connection.write(refusal(head.status));
        return connection.close_gently();
      }
      HeadStream stream(connection, head);
      const auto tell = [&](httplib::Request& request) {
        if (head.accepts_gzip) request.set_header(kAcceptsGzip, "1");
      };
      bool closed = n == kMaxRequestsPerConnection;
      if (!process_request(stream, closed, closed, tell) || closed) return connection.close_gently();
    }
  }

  std::size_t admit(int socket) {
    const std::lock_guard lock(mutex_);
    if (ending_) ::shutdown(socket, SHUT_RDWR);
    sockets_.insert(socket);
    return sockets_.size() - 1;
  }
  void leave(int socket) {
    const std::lock_guard lock(mutex_);
    sockets_.erase(socket);
  }

  std::mutex mutex_;
  std::set<int> sockets_;
  bool ending_ = false;
};

void say(httplib::Response& response, int status, const std::string& sentence) {
  response.status = status;
  response.set_content(sentence + "\n", "text/plain; charset=utf-8");
}

// Sends bytes in pieces, so that a browser that takes them slowly but steadily is not dropped.
void send_bytes(httplib::Response& response, std::string_view bytes, const std::string& type, std::shared_ptr<const void> owner) {
  if (bytes.empty()) return response.set_content("", type);
  response.set_content_provider(
      bytes.size(), type, [bytes, owner = std::move(owner)](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        return sink.write(bytes.data() + offset, std::min(length, kPieceBytes));
      });
}

}  // namespace

struct ViewerServer::State {
  // For the time in which an answer is made.
  struct Answering {
    explicit Answering(State& of) : state(of) { ++state.answering, state.asked_at = Clock::now(); }
    ~Answering() { state.asked_at = Clock::now(), --state.answering; }
    Answering(const Answering&) = delete;
    Answering& operator=(const Answering&) = delete;
    State& state;
  };

  State(ViewerOptions viewer_options, SnapshotScene scene, const LatestSnapshot& latest, PlaySource play, SceneHistory history)
      : options(std::move(viewer_options)), content(std::move(scene), latest, std::move(play), std::move(history)) {}

  void bind();
  void handle(const httplib::Request& request, httplib::Response& response);
  bool is_admitted(const httplib::Request& request, httplib::Response& response) const;
  bool send_asset(const httplib::Request& request, httplib::Response& response) const;
  void send_content(const httplib::Request& request, httplib::Response& response);
  void stream_events(httplib::Response& response);
  bool send_event(httplib::DataSink& sink, std::uint64_t& sent_revision, Clock::time_point& sent_at);
  void end_stream();

  std::string cookie_name() const { return fmt::format("panoptic_{}", port); }

  ViewerOptions options;
  std::uint16_t port = 0;
  bool is_loopback_only = true;
  ViewerContent content;
  HttpServer http;
  std::thread listener;
  std::atomic<Clock::time_point> asked_at{Clock::time_point::min()};  // by a browser, for the last time
  std::atomic<int> answering = 0;                                     // requests whose answers are being made
  std::mutex mutex;                                                   // of the three below
  std::condition_variable ending;
  bool is_ending = false;
  int streams = 0;
};

void ViewerServer::State::bind() {
  // Not SO_REUSEPORT, the library's own choice: two servers would share a port, each getting some of the requests.
  http.set_socket_options([](socket_t socket) {
    const int on = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  });
  const int first = options.port.value_or(kDefaultViewerPort);
  const int last = options.port.has_value() ? first : first + kPortsTried - 1;
  if (first == 0) {
    const int any = http.bind_to_any_port(options.bind);
    if (any > 0) port = static_cast<std::uint16_t>(any);
  }
  for (int candidate = first; candidate > 0 && candidate <= last && port == 0; ++candidate) {
    if (http.bind_to_port(options.bind, candidate)) port = static_cast<std::uint16_t>(candidate);
  }
  if (port != 0) return http.widen_queue();
  const std::string ports = first == last ? fmt::format("port {}", first) : fmt::format("any of the ports {} to {}", first, last);
  throw Error(
      fmt::format("the viewer cannot listen on {} of {}: it is taken, not allowed or not an address of this machine; "
                  "choose another with --port or --bind",
                  ports, options.bind));
}

bool ViewerServer::State::is_admitted(const httplib::Request& request, httplib::Response& response) const {
  if (is_loopback_only && !names_loopback(request.get_header_value("Host"))) {
    say(response, 403, "open the viewer by the address of this machine, as http://127.0.0.1");
    return false;
  }
  if (request.get_header_value("Sec-Fetch-Site") == "cross-site" && request.path != "/") {
    say(response, 403, "pages from elsewhere may not use the viewer");
    return false;
  }
  if (options.token.empty()) return true;
  const bool shown = request.has_param("token") && is_same_secret(options.token, request.get_param_value("token"));
  if (shown) {
    response.set_header("Set-Cookie", fmt::format("{}={}; HttpOnly; SameSite=Strict; Path=/", cookie_name(), options.token));
  }
  if (shown || is_same_secret(options.token, cookie_value(request.get_header_value("Cookie"), cookie_name()))) return true;
  say(response, 401, "this viewer needs its token: open the address that the program printed");
  return false;
}

bool ViewerServer::State::send_asset(const httplib::Request& request, httplib::Response& response) const {
  const auto assets = web_assets();
  const auto found = std::find_if(assets.begin(), assets.end(), [&](const WebAsset& a) { return a.path == request.path; });
  if (found == assets.end() && request.path != "/") return false;
  response.set_header("Cache-Control", "no-cache");
  if (found == assets.end()) {
    response.set_content(kNoPage.data(), kNoPage.size(), "text/html; charset=utf-8");
    return true;
  }
  const bool gzipped = !found->gzipped.empty() && request.has_header(kAcceptsGzip);
  if (!found->gzipped.empty()) response.set_header("Vary", "Accept-Encoding");
  if (gzipped) response.set_header("Content-Encoding", "gzip");
  send_bytes(response, gzipped ? found->gzipped : found->bytes, std::string(found->type), nullptr);
  return true;
}

void ViewerServer::State::send_content(const httplib::Request& request, httplib::Response& response) {
  response.set_header("Cache-Control", "no-store");
  const Answer answer = content.answer(request.path, {request.params.begin(), request.params.end()});
  response.status = answer.status;
  if (!answer.download_name.empty()) {
    response.set_header("Content-Disposition", fmt::format("attachment; filename=\"{}\"", answer.download_name));
  }
  send_bytes(response, *answer.body, answer.type, answer.body);
}

// One round: looks for a new snapshot and tells of it; false ends the stream.
bool ViewerServer::State::send_event(httplib::DataSink& sink, std::uint64_t& sent_revision, Clock::time_point& sent_at) {
  {
    std::unique_lock lock(mutex);
    if (ending.wait_for(lock, kLookEvery, [&] { return is_ending; })) return false;
  }
  if (!sink.is_writable()) return false;  // the browser left
  const auto newest = content.latest().newest();
  const auto silence = Clock::now() - sent_at;
  std::string text;
  if (newest->revision != sent_revision && silence >= kEventEvery) {
    text = fmt::format("event: state\ndata: {}\n\n", content.event(*newest));
    sent_revision = newest->revision;
  } else if (silence >= kSignOfLifeEvery) {
    text = ": still here\n\n";
  }
  if (text.empty()) return true;
  sent_at = Clock::now();
  return sink.write(text.data(), text.size());
}

void ViewerServer::State::stream_events(httplib::Response& response) {
  {
    const std::lock_guard lock(mutex);
    if (streams >= kMaxEventStreams) return say(response, 503, "too many browsers are watching");
    ++streams;
  }
  response.set_header("Cache-Control", "no-store");
  response.set_chunked_content_provider(
      "text/event-stream",
      [this, revision = ~std::uint64_t{0}, sent_at = Clock::time_point{}](std::size_t, httplib::DataSink& sink) mutable {
        return send_event(sink, revision, sent_at);
      },
      [this](bool) { end_stream(); });
}

// After the last browser left the surface is not kept for it any longer.
void ViewerServer::State::end_stream() {
  const std::lock_guard lock(mutex);
  if (--streams == 0) content.forget();
}

void ViewerServer::State::handle(const httplib::Request& request, httplib::Response& response) {
  const Answering answering_it(*this);
  if (!is_admitted(request, response)) return;
  if (request.path == "/events") {
    if (request.method == "HEAD") return say(response, 405, "GET it");
    return stream_events(response);
  }
  if (!send_asset(request, response)) send_content(request, response);
}

ViewerServer::ViewerServer(const ViewerOptions& options, SnapshotScene scene, const LatestSnapshot& latest, PlaySource play,
                           SceneHistory history) {
  if (!is_well_formed_token(options.token)) {
    throw Error("the viewer's token must have 8 to 128 characters of A-Z a-z 0-9 - . _ ~");
  }
  const bool is_local = is_loopback(options.bind);
  if (!is_local && options.token.empty()) {
    throw Error(fmt::format("the viewer on {} can be reached by others: add a token, for example --token {}", options.bind,
                            fresh_token()));
  }
  state_ = std::make_unique<State>(options, std::move(scene), latest, std::move(play), std::move(history));
  State& state = *state_;
  state.is_loopback_only = is_local;
  state.bind();
  state.http.new_task_queue = [] { return new httplib::ThreadPool(kMaxConnections + 4); };
  state.http.set_keep_alive_max_count(kMaxRequestsPerConnection);
  state.http.set_keep_alive_timeout(kIdle.count());
  state.http.set_default_headers(kSecurityHeaders);
  state.http.set_pre_routing_handler([&state](const httplib::Request& request, httplib::Response& response) {
    state.handle(request, response);
    return httplib::Server::HandlerResponse::Handled;
  });
  state.http.set_exception_handler([](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
    say(response, 500, "the server could not make this; the program's messages may tell why");
  });
  state.listener = std::thread([&state] { state.http.listen_after_bind(); });
  while (!state.http.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

ViewerServer::~ViewerServer() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->is_ending = true;
  }
  state_->ending.notify_all();
  state_->http.end_connections();
  state_->http.stop();
  state_->listener.join();
}

void ViewerServer::finish(const std::function<bool()>& wanted) const {
  constexpr auto kQuiet = std::chrono::seconds(2);
  constexpr auto kLongest = std::chrono::seconds(30);
  const auto since = Clock::now();
  const auto is_asked = [&] { return state_->answering > 0 || Clock::now() < state_->asked_at.load() + kQuiet; };
  while (wanted() && Clock::now() - since < kLongest && is_asked()) {
    std::this_thread::sleep_for(kLookEvery);
  }
}

std::string ViewerServer::url() const { return url_of(state_->options.bind, state_->port, state_->options.token); }

}  // namespace panoptic
