#include "sim/types/utf8.h"

#include <gtest/gtest.h>

#include <string>

namespace cousin {
namespace {

TEST(Utf8, CharactersOfOneToFourBytesAreUtf8) {
  EXPECT_TRUE(is_utf8(""));
  EXPECT_TRUE(is_utf8("maize"));
  EXPECT_TRUE(is_utf8("é"));
  EXPECT_TRUE(is_utf8("苺"));
  EXPECT_TRUE(is_utf8("\xf0\x9f\x8c\xb1"));
  EXPECT_TRUE(is_utf8("\xf4\x8f\xbf\xbf"));
}

TEST(Utf8, WhatUnicodeForbidsIsNotUtf8) {
  EXPECT_FALSE(is_utf8("Gr\xfcn"));           // Latin-1
  EXPECT_FALSE(is_utf8("\xc0\xaf"));          // an overlong slash
  EXPECT_FALSE(is_utf8("\xe0\x80\xaf"));      // the same in three bytes
  EXPECT_FALSE(is_utf8("\xed\xa0\x80"));      // a surrogate
  EXPECT_FALSE(is_utf8("\xf4\x90\x80\x80"));  // above U+10FFFF
  EXPECT_FALSE(is_utf8("\x80"));
  EXPECT_FALSE(is_utf8("\xc3"));  // ends within a character
}

TEST(Utf8, OnlyTheBytesThatAreNotUtf8AreShown) {
  EXPECT_EQ(readable_utf8("Gr\xfcn é"), "Gr\\xfcn é");
  EXPECT_EQ(readable_utf8("\xe8\x8b"), "\\xe8\\x8b");
  EXPECT_EQ(readable_utf8("苺"), "苺");
}

TEST(Utf8, EveryStringBecomesReadable) {
  for (int a = 0; a < 256; ++a) {
    for (int b = 0; b < 256; ++b) {
      const std::string text = {'x', static_cast<char>(a), static_cast<char>(b)};
      EXPECT_TRUE(is_utf8(readable_utf8(text)));
      EXPECT_TRUE(is_utf8(terminal_text(text)));
    }
  }
}

TEST(Utf8, ACutLeavesWholeCharacters) {
  const std::string text = "aé苺\xf0\x9f\x8c\xb1";  // 1 + 2 + 3 + 4 bytes
  const std::size_t whole[] = {0, 1, 1, 3, 3, 3, 6, 6, 6, 6, 10, 10};
  for (std::size_t most = 0; most < std::size(whole); ++most)
    EXPECT_EQ(cut_utf8(text, most), text.substr(0, whole[most])) << most;
}

TEST(Utf8, ACutOfBytesThatAreNoTextKeepsAsManyAsAllowed) {
  const std::string text(10, '\x80');
  EXPECT_EQ(cut_utf8(text, 5).size(), 5U);
}

TEST(Utf8, ATerminalIsNotToldAnything) {
  EXPECT_EQ(terminal_text("\x1b[2Jcalm"), "\\x1b[2Jcalm");
  EXPECT_EQ(terminal_text("a\rb\bc\x7f"), "a\\x0db\\x08c\\x7f");
  EXPECT_EQ(terminal_text("\xc2\x9b"), "\\u009b");      // CSI as one character
  EXPECT_EQ(terminal_text("\xe2\x80\xae"), "\\u202e");  // right to left from here
  EXPECT_EQ(terminal_text("Gr\xfcn"), "Gr\\xfcn");
  EXPECT_EQ(terminal_text("Grün 苺"), "Grün 苺");
}

TEST(Utf8, ALineBreakIsShownAndDoesNotAct) {
  EXPECT_EQ(terminal_text("a\n  cousin: verified"), "a\\x0a  cousin: verified");
  EXPECT_EQ(terminal_text("a.png\ncousin: done"), "a.png\\x0acousin: done");
}

}  // namespace
}  // namespace cousin
