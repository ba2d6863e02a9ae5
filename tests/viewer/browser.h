// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A browser at its barest: a socket to a server on this machine, and what came back.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <string>

namespace panoptic::test {

struct HttpAnswer {
  int status = 0;  // 0: the connection ended without an answer
  std::map<std::string, std::string> headers;
  std::string body;
};

class Browser {
 public:
  explicit Browser(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)), port_(port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  }
  ~Browser() { leave(); }
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  bool connected() const { return connected_; }
  void leave() {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
  }

  // May fail silently: servers hang up on browsers that misbehave.
  void say(const std::string& bytes) const { (void)::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  void ask(const std::string& target, const std::string& headers = "") const {
    say("GET " + target + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) + "\r\n" + headers + "\r\n");
  }

  // Receives until the text is there; false if the connection ends or the time is over before that.
  bool hear(const std::string& text, std::chrono::milliseconds patience = std::chrono::seconds(8)) {
    const auto until = std::chrono::steady_clock::now() + patience;
    while (heard_.find(text) == std::string::npos) {
      if (!receive(until)) return false;
    }
    return true;
  }
  const std::string& heard() const { return heard_; }

  HttpAnswer answer() {
    HttpAnswer a;
    if (!hear("\r\n\r\n")) return a;
    const std::size_t end = heard_.find("\r\n\r\n");
    a.status = std::stoi(heard_.substr(9, 3));
    for (std::size_t at = heard_.find("\r\n") + 2; at < end;) {
      const std::size_t colon = heard_.find(": ", at);
      const std::size_t line_end = heard_.find("\r\n", at);
      a.headers[heard_.substr(at, colon - at)] = heard_.substr(colon + 2, line_end - colon - 2);
      at = line_end + 2;
    }
    const std::size_t length = a.headers.contains("Content-Length") ? std::stoul(a.headers["Content-Length"]) : 0;
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(8);
    while (heard_.size() < end + 4 + length) {
      if (!receive(until)) break;
    }
    a.body = heard_.substr(end + 4, length);
    heard_.erase(0, end + 4 + length);
    return a;
  }

  // True once the server has ended the connection.
  bool is_ended(std::chrono::milliseconds patience) {
    const auto until = std::chrono::steady_clock::now() + patience;
    while (receive(until)) {
    }
    return std::chrono::steady_clock::now() < until;
  }

 private:
  bool receive(std::chrono::steady_clock::time_point until) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now()).count();
    pollfd one{socket_, POLLIN, 0};
    if (left <= 0 || ::poll(&one, 1, static_cast<int>(left)) <= 0) return false;
    std::array<char, 65536> buffer{};
    const ssize_t count = ::recv(socket_, buffer.data(), buffer.size(), 0);
    if (count <= 0) return false;
    heard_.append(buffer.data(), static_cast<std::size_t>(count));
    return true;
  }

  int socket_;
  std::uint16_t port_;
  bool connected_ = false;
  std::string heard_;
};

// One question on a connection of its own.
inline HttpAnswer fetch(std::uint16_t port, const std::string& target, const std::string& headers = "") {
  Browser browser(port);
  browser.ask(target, headers);
  return browser.answer();
}

// The server's answer to these bytes.
inline HttpAnswer tell(std::uint16_t port, const std::string& bytes) {
  Browser browser(port);
  browser.say(bytes);
  return browser.answer();
}

}  // namespace panoptic::test
