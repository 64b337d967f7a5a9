#include "benchmarks/report/html.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "benchmarks/report/shown_numbers.h"

namespace cousin {
namespace {

TEST(Html, EscapesWhatWouldBecomeMarkup) {
  EXPECT_EQ(html_text("<a href=\"x\">&'").str(), "&lt;a href=&quot;x&quot;&gt;&amp;&#39;");
}

TEST(Html, ShowsWhatIsNoTextAndKeepsWhatIs) {
  EXPECT_EQ(html_text("Gr\xfcn\x1b[2J\r\n\t苺").str(), "Gr\\xfcn\\x1b[2J\r\n\t苺");
}

TEST(Html, GrowsByMarkupOfTheSourceAndByEscapedTextOnly) {
  static_assert(!std::is_constructible_v<Html, std::string>);
  static_assert(!std::is_constructible_v<Html, std::string_view>);
  static_assert(!std::is_constructible_v<Markup, std::string>);
  Html cell = "<td>" + html_text("a < b");
  cell += "</td>";
  EXPECT_EQ(cell.str(), "<td>a &lt; b</td>");
}

TEST(Html, JsonEndsNoScriptElement) {
  const nlohmann::ordered_json json = {{"</script>", "<!-- \xe2\x80\xa8 \xe2\x80\xa9 \xff"}};
  const std::string text = html_json(json).str();
  EXPECT_EQ(text, "{\"\\u003c/script>\":\"\\u003c!-- \\u2028 \\u2029 \xef\xbf\xbd\"}");
  EXPECT_EQ(nlohmann::json::parse(text).begin().key(), "</script>");
}

// RFC 4648, section 10.
TEST(Base64, AgreesWithTheStandardsExamples) {
  const char* words[] = {"", "f", "fo", "foo", "foob", "fooba", "foobar"};
  const char* codes[] = {"", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"};
  for (int i = 0; i < 7; ++i) EXPECT_EQ(base64(std::string_view(words[i])), codes[i]);
  EXPECT_EQ(base64(std::vector<std::uint8_t>{0xff, 0xfe}), "//4=");
}

TEST(Html, AProgramsTextEndsNeitherItsElementNorOpensAComment) {
  EXPECT_EQ(html_script("a = '</Script>' < b; c = '<!--';").str(),
            "<script>\na = '<\\/Script>' < b; c = '<\\!--';</script>\n");
  // A regular expression that ends right after "<" stays one.
  EXPECT_EQ(html_script("s.replace(/</g, '')").str(), "<script>\ns.replace(/</g, '')</script>\n");
  EXPECT_EQ(html_script("<").str(), "<script>\n<</script>\n");
}

TEST(ShownNumber, HasThreeDigitsAndNoNeedlessExponent) {
  EXPECT_EQ(shown_number(0.12345), "0.123");
  EXPECT_EQ(shown_number(12.345), "12.3");
  EXPECT_EQ(shown_number(123456), "123456");
  EXPECT_EQ(shown_number(-0.00123), "-0.00123");
  EXPECT_EQ(shown_number(0), "0");
  EXPECT_EQ(shown_number(1e-9), "1e-09");
  EXPECT_EQ(shown_number(std::nan("")), "–");
  EXPECT_EQ(shown_interval({0.001, 0.0005, 0.002}, 1e3), "1.00 [0.500, 2.00]");
  EXPECT_EQ(shown_interval({.value = 0.001}, 1e3), "1.00");
}

TEST(ShownNumber, OnCardsHasEnoughDigitsForAPublishedOne) {
  EXPECT_EQ(shown_precisely(120.044), "120.04");
  EXPECT_EQ(shown_precisely(-701.006), "-701.01");
  EXPECT_EQ(shown_precisely(12.345), "12.35");
  EXPECT_EQ(shown_precisely(60), shown_number(60));
  EXPECT_EQ(shown_precisely(0.12345), shown_number(0.12345));
  EXPECT_EQ(shown_precisely(123456.7), shown_number(123456.7));
  EXPECT_EQ(shown_precisely(std::nan("")), "–");
}

TEST(ShownUnit, IsWhatPeopleRead) {
  EXPECT_EQ(shown_unit("m").name, "mm");
  EXPECT_EQ(shown_unit("m3").factor, 1e9);
  EXPECT_EQ(shown_unit("1", "length.mape").name, "%");
  EXPECT_EQ(shown_unit("1", "length.slope").name, "");
  EXPECT_EQ(shown_unit("s").name, "s");
}

}  // namespace
}  // namespace cousin
