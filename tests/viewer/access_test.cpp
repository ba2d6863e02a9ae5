// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/access.h"

#include <gtest/gtest.h>

namespace panoptic {
namespace {

TEST(Access, KnowsLoopbackAddresses) {
  for (const char* address : {"127.0.0.1", "127.9.9.9", "localhost", "LocalHost", "::1", "0:0:0:0:0:0:0:1"}) {
    EXPECT_TRUE(is_loopback(address)) << address;
  }
  for (const char* address :
       {"", "0.0.0.0", "128.0.0.1", "::", "::2", "127.0.0.1.example.org", "localhost.example.org", "1270.0.0.1"}) {
    EXPECT_FALSE(is_loopback(address)) << address;
  }
}

TEST(Access, OnlyHostsOfThisMachineNameLoopback) {
  for (const char* host : {"127.0.0.1", "127.0.0.1:8060", "localhost:8060", "[::1]:8060", "[::1]"}) {
    EXPECT_TRUE(names_loopback(host)) << host;
  }
  for (const char* host :
       {"", "example.org", "example.org:8060", "127.0.0.1.example.org:8060", "[::1", "[::1]x", ":8060", "::1", "[]"}) {
    EXPECT_FALSE(names_loopback(host)) << host;
  }
}

TEST(Access, TokensNeedNoEscapeAndHaveALength) {
  for (const std::string& token :
       {std::string(), std::string("abcDEF12"), std::string("a-b.c_d~"), std::string(128, 'x'), fresh_token()}) {
    EXPECT_TRUE(is_well_formed_token(token)) << token;
  }
  for (const std::string& token : {std::string("short12"), std::string(129, 'x'), std::string("with space"),
                                   std::string("a;b;c;d;e"), std::string("new\r\nline"), std::string("zero\0zero", 9)}) {
    EXPECT_FALSE(is_well_formed_token(token)) << token;
  }
  EXPECT_NE(fresh_token(), fresh_token());
}

TEST(Access, SecretsAreTheSameInEveryCharacter) {
  EXPECT_TRUE(is_same_secret("secret12", "secret12"));
  EXPECT_TRUE(is_same_secret("", ""));
  for (const char* other : {"", "secret1", "secret13", "Secret12", "secret12secret12", "secret123"}) {
    EXPECT_FALSE(is_same_secret("secret12", other)) << other;
    EXPECT_FALSE(is_same_secret(other, "secret12")) << other;
  }
}

TEST(Access, FindsACookieAmongOthers) {
  EXPECT_EQ(cookie_value("a=1; panoptic_8060=tok; b=2", "panoptic_8060"), "tok");
  EXPECT_EQ(cookie_value("panoptic_8060=tok", "panoptic_8060"), "tok");
  EXPECT_EQ(cookie_value("xpanoptic_8060=tok; panoptic_80601=no", "panoptic_8060"), "");
  for (const char* header : {"", ";", ";;; ;", "panoptic_8060", "=", "panoptic_8060="}) {
    EXPECT_EQ(cookie_value(header, "panoptic_8060"), "") << header;
  }
}

TEST(Access, AddressesAreFitToBeOpened) {
  EXPECT_EQ(url_of("127.0.0.1", 8060, ""), "http://127.0.0.1:8060/");
  EXPECT_EQ(url_of("::1", 80, ""), "http://[::1]:80/");
  EXPECT_EQ(url_of("192.168.1.5", 8061, "secret12"), "http://192.168.1.5:8061/?token=secret12");
  EXPECT_EQ(url_of("0.0.0.0", 1, "secret12").find("0.0.0.0"), std::string::npos) << "nobody can open that";
}

}  // namespace
}  // namespace panoptic
