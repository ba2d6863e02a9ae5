// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Rules for who may ask: loopback addresses, tokens, and names of the host. Pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace panoptic {

// True for 127.0.0.0/8, ::1 and "localhost".
bool is_loopback(std::string_view address);

// True for an empty token, and for 8 to 128 characters that need no escape in an address.
bool is_well_formed_token(std::string_view token);

// Compares two texts; takes the same time wherever they differ.
bool is_same_secret(std::string_view a, std::string_view b);

// A token for a person who has none yet.
std::string fresh_token();

// True if a request's Host header names this machine's loopback. A page from elsewhere whose name was made to point here (DNS
// rebinding) sends its own name.
bool names_loopback(std::string_view host_header);

// The value of "name=value" in a Cookie header; empty if it is not there.
std::string_view cookie_value(std::string_view cookie_header, std::string_view name);

// The address to open for a server bound there, such as "http://127.0.0.1:8060/".
std::string url_of(std::string_view bind, std::uint16_t port, std::string_view token);

}  // namespace panoptic
