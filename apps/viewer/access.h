// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Who may ask: loopback addresses, tokens, and names of the host. Pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace panoptic {

// 127.0.0.0/8, ::1 or "localhost".
bool is_loopback(std::string_view address);

// Empty, or 8 to 128 characters that need no escape in an address.
bool is_well_formed_token(std::string_view token);

// Takes the same time wherever they differ.
bool is_same_secret(std::string_view a, std::string_view b);

// A token for a person who has none yet.
std::string fresh_token();

// Does a request's Host header name this machine's loopback? A page from elsewhere whose name was made to point here (DNS
// rebinding) sends its own name.
bool names_loopback(std::string_view host_header);

// "name=value" of a Cookie header; empty if it is not there.
std::string_view cookie_value(std::string_view cookie_header, std::string_view name);

// "http://127.0.0.1:8060/": what to open for a server bound to the address.
std::string url_of(std::string_view bind, std::uint16_t port, std::string_view token);

}  // namespace panoptic
