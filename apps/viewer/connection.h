// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One browser's connection, with the patience and the memory that the server has for it.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

namespace panoptic {

struct ConnectionLimits {
  std::size_t max_head_bytes = 16384;  // request line and headers
  std::size_t max_headers = 64;
  std::chrono::milliseconds idle{15000};   // silence between two requests
  std::chrono::milliseconds head{5000};    // from the first byte of a request to the end of its headers
  std::chrono::milliseconds write{10000};  // for each piece of an answer
};

// The result of reading a request: nothing (status 0: the browser left or was silent), a complete head that may be parsed
// (200), or why the request is refused.
struct RequestHead {
  int status = 0;
  std::string text;  // up to and including the empty line; headers that the server has no use for are left out
  bool accepts_gzip = false;
  bool is_event_stream = false;  // asks for /events
};

// Owns a connected socket. Used by one thread.
class Connection {
 public:
  Connection(int socket, const ConnectionLimits& limits);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Waits for the next request and takes its head. Requests with a body are refused, whatever their method.
  RequestHead read_head();

  // Sends all of it within the limit; false if the browser is gone or too slow.
  bool write(std::string_view bytes) const;

  // True if the browser has closed its side.
  bool is_left() const;

  // Says goodbye so that the browser can still read the last answer: ends our side, then waits a moment for the other's end.
  void close_gently();

  int socket() const { return socket_; }

 private:
  enum class Received { kBytes, kNothingInTime, kEnd };
  Received receive(std::chrono::steady_clock::time_point until);

  int socket_;
  ConnectionLimits limits_;
  std::string unread_;  // received, but not yet taken as a head
};

// The answer to a request that is refused before the server sees it: status line, headers and a sentence.
std::string refusal(int status);

// Checks a complete head (request line, headers, empty line) and strips it to what the server uses. Pure.
RequestHead checked_head(std::string_view text, std::size_t max_headers);

}  // namespace panoptic
