#include "viewer/rules.h"

#include <gtest/gtest.h>

#include <set>

#include "viewer/command.h"
#include "viewer/page.h"

namespace livemvs::viewer {
namespace {

const AccessRules kRules = {"0123456789abcdef0123456789abcdef",
                            {"127.0.0.1:7451", "localhost:7451"},
                            {"http://127.0.0.1:7451", "http://localhost:7451"},
                            "livemvs_7451"};
constexpr char kCookie[] = "theme=dark; livemvs_7451=0123456789abcdef0123456789abcdef";

RequestHead Get(std::string_view target, std::string_view cookies = kCookie) {
  return {"GET", target, "127.0.0.1:7451", "", cookies, false};
}

RequestHead Upgrade(std::string_view origin, std::string_view cookies = kCookie) {
  return {"GET", "/stream", "127.0.0.1:7451", origin, cookies, true};
}

TEST(Rules, ATokenOpensThePageAndItsCookieTheRest) {
  EXPECT_EQ(Judge(Get("/?token=0123456789abcdef0123456789abcdef", ""), kRules), Verdict::kPage);
  EXPECT_EQ(Judge(Get("/"), kRules), Verdict::kPage);
  EXPECT_EQ(Judge(Get("/app.js"), kRules), Verdict::kAsset);
  EXPECT_EQ(Judge(Upgrade("http://127.0.0.1:7451"), kRules), Verdict::kStream);
  EXPECT_EQ(Judge(Upgrade("http://localhost:7451"), kRules), Verdict::kStream);
}

TEST(Rules, WithoutATokenNothingIsServed) {
  for (const std::string_view target :
       {"/", "/app.js", "/stream", "/?token=", "/?token=0123456789abcdef0123456789abcdee"}) {
    EXPECT_EQ(Judge(Get(target, ""), kRules), Verdict::kForbidden) << target;
  }
  // A wrong token is not made good by a right cookie; two tokens are none.
  EXPECT_EQ(Judge(Get("/?token=ffff"), kRules), Verdict::kForbidden);
  EXPECT_EQ(Judge(Upgrade("http://127.0.0.1:7451", ""), kRules), Verdict::kForbidden);
  EXPECT_EQ(Judge(Upgrade("http://127.0.0.1:7451", "livemvs_7452=0123456789abcdef0123456789abcdef"),
                  kRules),
            Verdict::kForbidden);
}

TEST(Rules, OtherHostsAndOriginsAreRefused) {
  for (const std::string_view host : {"evil.example:7451",
                                      "127.0.0.1",
                                      "127.0.0.1:74510",
                                      "127.0.0.1:7451.evil.example",
                                      "LOCALHOST:7451",
                                      ""}) {
    RequestHead request = Get("/");
    request.host = host;
    EXPECT_EQ(Judge(request, kRules), Verdict::kWrongHost) << host;
  }
  for (const std::string_view origin : {"http://evil.example",
                                        "http://127.0.0.1:7451.evil.example",
                                        "https://127.0.0.1:7451",
                                        "null",
                                        ""}) {
    EXPECT_EQ(Judge(Upgrade(origin), kRules), Verdict::kWrongOrigin) << origin;
  }
  RequestHead request = Get("/app.js");
  request.origin = "http://evil.example";
  EXPECT_EQ(Judge(request, kRules), Verdict::kWrongOrigin);
}

TEST(Rules, OnlyTheTablesFilesExist) {
  for (const std::string_view target : {"/../etc/passwd",
                                        "/app.js/",
                                        "//app.js",
                                        "/%2e%2e/app.js",
                                        "/app.js%00",
                                        "/index.html",
                                        "/stream",
                                        "app.js"}) {
    EXPECT_EQ(Judge(Get(target), kRules), Verdict::kNotFound) << target;
  }
  RequestHead request = Upgrade("http://127.0.0.1:7451");
  request.target = "/other";
  EXPECT_EQ(Judge(request, kRules), Verdict::kNotFound);
  request = Get("/");
  request.method = "POST";
  EXPECT_EQ(Judge(request, kRules), Verdict::kBadMethod);
}

TEST(Rules, QueriesAreReadStrictly) {
  EXPECT_EQ(QueryParameter("/?a=1&b=x_-Z", "b"), "x_-Z");
  EXPECT_EQ(QueryParameter("/?a=1&a=2", "a"), std::nullopt);
  EXPECT_EQ(QueryParameter("/?a=1%20", "a"), std::nullopt);
  EXPECT_EQ(QueryParameter("/?aa=1", "a"), std::nullopt);
  EXPECT_EQ(QueryParameter("/?a", "a"), std::nullopt);
  EXPECT_EQ(QueryParameter("/", "a"), std::nullopt);
  EXPECT_EQ(QueryParameter("/?a=", "a"), "");
  EXPECT_EQ(CookieValue("a=1; b=2;c=3", "b"), "2");
  EXPECT_EQ(CookieValue("a=1; b=2;c=3", "c"), "3");
  EXPECT_EQ(CookieValue("ab=1", "b"), std::nullopt);
  EXPECT_EQ(CookieValue("b", "b"), std::nullopt);
}

TEST(Rules, AResumeIsANameAndANumber) {
  const Resume good = ParseResume("/stream?session=abc&from=17");
  EXPECT_EQ(good.session, "abc");
  EXPECT_EQ(good.from, 17U);
  for (const char* target : {"/stream",
                             "/stream?session=abc",
                             "/stream?session=abc&from=-1",
                             "/stream?session=abc&from=4294967296",
                             "/stream?session=abc&from=1x",
                             "/stream?session=abc&from="}) {
    EXPECT_EQ(ParseResume(target).session, "") << target;
    EXPECT_EQ(ParseResume(target).from, 0U) << target;
  }
}

TEST(Rules, TokensAreLongAndDiffer) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) tokens.insert(MakeToken());
  EXPECT_EQ(tokens.size(), 100U);
  for (const std::string& token : tokens) EXPECT_EQ(token.size(), 32U);
  EXPECT_TRUE(EqualInConstantTime("abc", "abc"));
  EXPECT_FALSE(EqualInConstantTime("abc", "abd"));
  EXPECT_FALSE(EqualInConstantTime("abc", "ab"));
}

TEST(Command, IsOneOfThree) {
  EXPECT_EQ(ParseCommand(R"({"do":"pause"})"), Command::kPause);
  EXPECT_EQ(ParseCommand(R"({"do":"resume"})"), Command::kResume);
  EXPECT_EQ(ParseCommand(R"( { "do" : "finish" } )"), Command::kFinish);
  for (const char* text : {"",
                           "pause",
                           R"({"do":"save"})",
                           R"({"do":"pause","path":"/x"})",
                           R"({"do":1})",
                           R"(["pause"])",
                           R"({"do":"pause")",
                           "{\"do\":\"pause\xff\"}"}) {
    EXPECT_EQ(ParseCommand(text), std::nullopt) << text;
  }
  EXPECT_EQ(ParseCommand(std::string(kMaxCommandBytes + 1, ' ')), std::nullopt);
  EXPECT_EQ(ParseCommand(std::string(kMaxCommandBytes, '[')), std::nullopt);
}

TEST(Page, HasWhatItsHtmlNames) {
  const Asset* page = FindAsset("/");
  ASSERT_NE(page, nullptr);
  for (const char* name : {"app.js", "app.css", "icon.svg"}) {
    EXPECT_NE(page->bytes.find(name), std::string_view::npos) << name;
    ASSERT_NE(FindAsset("/" + std::string(name)), nullptr) << name;
    EXPECT_GT(FindAsset("/" + std::string(name))->bytes.size(), 100U) << name;
  }
  EXPECT_NE(FindAsset("/app.css")->bytes.find("inter.woff2"), std::string_view::npos);
  EXPECT_EQ(FindAsset("/inter.woff2")->bytes.substr(0, 4), "wOF2");
  EXPECT_EQ(FindAsset("/missing"), nullptr);
  // Nothing comes from elsewhere, and no script stands in the page.
  EXPECT_EQ(page->bytes.find("://"), std::string_view::npos);
  EXPECT_EQ(page->bytes.find("<script>"), std::string_view::npos);
}

}  // namespace
}  // namespace livemvs::viewer
