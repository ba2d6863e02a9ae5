// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/connection.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "panoptic/base/config.h"

namespace panoptic {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::string_view kEndOfHead = "\r\n\r\n";
constexpr std::chrono::milliseconds kGoodbye{200};

// True once the socket is ready for the events, or has failed, which the next call on it will tell.
bool wait_for(int socket, short events, Clock::time_point until) {
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
    if (left <= 0) return false;
    pollfd one{socket, events, 0};
    const int ready = ::poll(&one, 1, static_cast<int>(left));
    if (ready > 0) return true;
    if (ready == 0 || errno != EINTR) return false;
  }
}

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool is_same_name(std::string_view a, std::string_view lower_case) {
  return a.size() == lower_case.size() &&
         std::equal(a.begin(), a.end(), lower_case.begin(), [](char x, char y) { return lower(x) == y; });
}

bool is_printable(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c == '\t' || static_cast<unsigned char>(c) >= 0x20; });
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

// Only these reach the library that parses requests: what it would do with others (ranges, compression, expectations) the
// server does not need.
bool is_used(std::string_view name) {
  constexpr std::array<std::string_view, 4> kUsed = {"host", "connection", "cookie", "sec-fetch-site"};
  return std::any_of(kUsed.begin(), kUsed.end(), [&](std::string_view used) { return is_same_name(name, used); });
}

// 200 if "GET /path HTTP/1.1" is what it says.
int request_line_status(std::string_view line) {
  const std::size_t first = line.find(' ');
  const std::size_t last = line.rfind(' ');
  if (first == std::string_view::npos || first == last || line.find(' ', first + 1) != last) return 400;
  const std::string_view version = line.substr(last + 1);
  if (version != "HTTP/1.1" && version != "HTTP/1.0") return version.starts_with("HTTP/") ? 505 : 400;
  if (line.substr(0, first) != "GET" && line.substr(0, first) != "HEAD") return 405;
  return line[first + 1] == '/' ? 200 : 400;
}

// Takes one header into the head; the status that it leads to.
int take_header(std::string_view line, RequestHead& head) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || colon == 0 || line.substr(0, colon).find_first_of(" \t") != std::string_view::npos)
    return 400;
  const std::string_view name = line.substr(0, colon);
  const std::string_view value = trimmed(line.substr(colon + 1));
  if (is_same_name(name, "transfer-encoding")) return 413;
  if (is_same_name(name, "content-length") && value != "0") return 413;
  if (is_same_name(name, "accept-encoding")) head.accepts_gzip = value.find("gzip") != std::string_view::npos;
  if (is_used(name)) head.text += fmt::format("{}: {}\r\n", name, value);
  return 200;
}

std::string_view reason(int status) {
  switch (status) {
    case 400:
      return "Bad Request";
    case 405:
      return "Method Not Allowed";
    case 408:
      return "Request Timeout";
    case 413:
      return "Content Too Large";
    case 431:
      return "Request Header Fields Too Large";
    case 503:
      return "Service Unavailable";
    case 505:
      return "HTTP Version Not Supported";
    default:
      return "Error";
  }
}

}  // namespace

std::string refusal(int status) {
  const std::string body = fmt::format("{} {}\n", status, reason(status));
  return fmt::format("HTTP/1.1 {} {}\r\n{}Connection: close\r\nContent-Type: text/plain\r\nContent-Length: {}\r\n\r\n{}", status,
                     reason(status), status == 405 ? "Allow: GET, HEAD\r\n" : "", body.size(), body);
}

RequestHead checked_head(std::string_view text, std::size_t max_headers) {
  RequestHead head;
  std::size_t lines = 0;
  while (!text.empty()) {
    const std::size_t end = text.find("\r\n");
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 2);
    if (lines > 0 && line.empty()) break;
    if (!is_printable(line)) return {400, {}};
    if (lines > max_headers) return {431, {}};
    const int status = lines == 0 ? request_line_status(line) : take_header(line, head);
    if (status != 200) return {status, {}};
    if (lines == 0) {
      head.text = fmt::format("{}\r\n", line);
      head.is_event_stream = line.find(" /events") != std::string_view::npos;
    }
    ++lines;
  }
  if (lines == 0) return {400, {}};
  head.text += "\r\n";
  head.status = 200;
  return head;
}

Connection::Connection(int socket, const ConnectionLimits& limits) : socket_(socket), limits_(limits) {
  const int on = 1;
  ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));  // answers are sent in two pieces
}

Connection::~Connection() { ::close(socket_); }

// Appends what is there to unread_.
Connection::Received Connection::receive(Clock::time_point until) {
  std::array<char, 4096> buffer{};
  for (;;) {
    if (!wait_for(socket_, POLLIN, until)) return Received::kNothingInTime;
    const ssize_t count = ::recv(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (count > 0) {
      unread_.append(buffer.data(), static_cast<std::size_t>(count));
      return Received::kBytes;
    }
    if (count == 0 || (errno != EAGAIN && errno != EINTR)) return Received::kEnd;
  }
}

RequestHead Connection::read_head() {
  if (unread_.empty() && receive(Clock::now() + limits_.idle) != Received::kBytes) return {};
  const auto until = Clock::now() + limits_.head;
  std::size_t searched = 0;
  for (;;) {
    const std::size_t end = unread_.find(kEndOfHead, searched);
    if (end != std::string::npos && end + kEndOfHead.size() <= limits_.max_head_bytes) {
      const std::string text = unread_.substr(0, end + kEndOfHead.size());
      unread_.erase(0, text.size());
      return checked_head(text, limits_.max_headers);
    }
    if (unread_.size() > limits_.max_head_bytes) return {431, {}};
    searched = unread_.size() < kEndOfHead.size() ? 0 : unread_.size() - kEndOfHead.size() + 1;
    const Received received = receive(until);
    if (received != Received::kBytes) return {received == Received::kEnd ? 0 : 408, {}};
  }
}

bool Connection::write(std::string_view bytes) const {
  const auto until = Clock::now() + limits_.write;
  while (!bytes.empty()) {
    const ssize_t count = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(count));
    } else if (count < 0 && errno == EAGAIN) {
      if (!wait_for(socket_, POLLOUT, until)) return false;
    } else if (count == 0 || errno != EINTR) {
      return false;
    }
    if (!bytes.empty() && Clock::now() > until) return false;
  }
  return true;
}

bool Connection::is_left() const {
  pollfd one{socket_, POLLRDHUP, 0};
  return ::poll(&one, 1, 0) > 0 && (one.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

void Connection::close_gently() {
  ::shutdown(socket_, SHUT_WR);
  const auto until = Clock::now() + kGoodbye;
  unread_.clear();
  while (receive(until) == Received::kBytes) unread_.clear();
}

}  // namespace panoptic
