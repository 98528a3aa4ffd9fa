// Requests are answered for the right token, host and origin only.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/gate.h"

#include <gtest/gtest.h>

#include <set>

namespace kindling {
namespace {

constexpr const char* kToken = "0123456789abcdef0123456789abcdef";

HttpRequest request_of(const std::string& target, const std::string& host = "127.0.0.1:8600") {
  return {.method = "GET", .target = target, .body = {}, .headers = {{"host", host}}};
}

TEST(Gate, TokensAreRandomAndCompareWhole) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) tokens.insert(make_token());
  EXPECT_EQ(tokens.size(), 100U);
  for (const std::string& token : tokens) {
    EXPECT_EQ(token.size(), 32U);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
  }
  EXPECT_TRUE(is_token(kToken, kToken));
  const std::string token(kToken);
  for (size_t i = 0; i < token.size(); ++i) {
    std::string wrong = token;
    wrong[i] = 'x';
    EXPECT_FALSE(is_token(wrong, token)) << i;
    EXPECT_FALSE(is_token(token.substr(0, i), token)) << i;
  }
  EXPECT_FALSE(is_token(token + token, token)); // the token twice
  EXPECT_FALSE(is_token("", token));
}

TEST(Gate, PassesTheRestOfTheTarget) {
  const Gate gate(kToken, "127.0.0.1", "box");
  const std::string link = std::string("/") + kToken + "/";
  for (const std::string rest : {"", "view.css", "frame?after=1&image=2"}) {
    const HttpRequest request = request_of(link + rest);
    EXPECT_EQ(gate.check(request).status, 0) << rest;
    EXPECT_EQ(gate.inner_target(request), rest);
  }
  EXPECT_EQ(gate.inner_target(request_of(std::string("/") + kToken)), "");
  EXPECT_EQ(gate.check(request_of(std::string("/") + kToken + "x/")).status, 403);
  EXPECT_EQ(gate.check(request_of(std::string("//") + kToken + "/")).status, 403);
  EXPECT_EQ(gate.check(request_of(kToken)).status, 400);
}

TEST(Gate, LoopbackAnswersLoopbackNamesOnly) {
  const Gate gate(kToken, "127.0.0.1", "box");
  const std::string link = std::string("/") + kToken + "/";
  for (const char* host : {"127.0.0.1", "127.0.0.1:1", "localhost:65535", "LocalHost", "[::1]:8600", "127.1.2.3"})
    EXPECT_EQ(gate.check(request_of(link, host)).status, 0) << host;
  for (const char* host : {"box", "box:8600", "10.0.0.1", "a.example", "localhost.a.example", "127.0.0.1.a.example",
                           "127.a.example", "", ":8600", "localhost:", "localhost:1:2", "[::1", "::1]"})
    EXPECT_EQ(gate.check(request_of(link, host)).status, 421) << host;
}

TEST(Gate, OtherAddressesAnswerThisHostAndAddresses) {
  const Gate gate(kToken, "0.0.0.0", "Box");
  const std::string link = std::string("/") + kToken + "/";
  for (const char* host : {"box:8600", "BOX", "10.0.0.1:8600", "[fe80::1]:8600", "localhost"})
    EXPECT_EQ(gate.check(request_of(link, host)).status, 0) << host;
  for (const char* host : {"a.example", "box.example", ""})
    EXPECT_EQ(gate.check(request_of(link, host)).status, 421) << host;
}

TEST(Gate, RefusesOtherOriginsAndBodies) {
  const Gate gate(kToken, "127.0.0.1", "box");
  const auto status = [&](const char* name, const char* value) {
    HttpRequest request = request_of(std::string("/") + kToken + "/");
    request.headers.emplace_back(name, value);
    return gate.check(request).status;
  };
  EXPECT_EQ(status("origin", "http://127.0.0.1:8600"), 0);
  EXPECT_EQ(status("origin", "http://127.0.0.1:8601"), 403);
  EXPECT_EQ(status("origin", "null"), 403);
  EXPECT_EQ(status("sec-fetch-site", "same-origin"), 0);
  EXPECT_EQ(status("sec-fetch-site", "same-site"), 403);
  EXPECT_EQ(status("host", "127.0.0.1"), 421); // twice
  EXPECT_EQ(status("transfer-encoding", "chunked"), 411);
  EXPECT_EQ(status("content-encoding", "gzip"), 411);
  HttpRequest post = request_of(std::string("/") + kToken + "/change");
  post.method = "POST";
  EXPECT_EQ(gate.check(post).status, 415);
  post.headers.emplace_back("content-type", "application/json");
  EXPECT_EQ(gate.check(post).status, 415);
  post.headers.emplace_back("content-length", "2");
  EXPECT_EQ(gate.check(post).status, 0);
}

} // namespace
} // namespace kindling
