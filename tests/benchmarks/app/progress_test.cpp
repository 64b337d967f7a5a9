// What long work says of itself: plain lines into a file, a bar on a terminal, nothing when quiet.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <string>

#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(AppProgress, PlainLinesSayHowMuchIsDoneOfHowMuch) {
  const Program program;
  const Outcome first = program.run(Words{"render", "seeds", "--out", "d"} + tiny_scene());
  ASSERT_EQ(first.code, 0) << first.err;
  EXPECT_THAT(first.err, AllOf(HasSubstr("render 000000 0/2"), HasSubstr("dataset: d"),
                               Not(HasSubstr("\r")), Not(HasSubstr("already"))));
  const Outcome verified = program.run({"verify", "d"});
  EXPECT_THAT(verified.err, testing::ContainsRegex("verify 0/[0-9]+"));
  for (const char* word : {"--quiet", "--json"})
    EXPECT_EQ(program.run({"verify", "d", word}).err, "") << word;
}

TEST(AppProgress, WhatAnEarlierRunLeftIsSaid) {
  const Program program;
  const Words words = Words{"render", "seeds", "--out", "d"} + tiny_scene();
  ASSERT_EQ(program.run(words).code, 0);
  const Outcome again = program.run(words);
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("scene 000000: 2 of 2 views are there already"));
  std::filesystem::remove(program.path("d/000000/rgb/000001.png"));
  const Outcome rest = program.run(words);
  EXPECT_EQ(rest.code, 0) << rest.err;
  EXPECT_THAT(rest.err, AllOf(HasSubstr("scene 000000: 1 of 2 views are there already"),
                              HasSubstr("render 000000 1/2")));
}

TEST(AppProgress, OnATerminalABarIsDrawn) {
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  if (terminal < 0 || grantpt(terminal) != 0 || unlockpt(terminal) != 0)
    GTEST_SKIP() << "no terminal can be made here";
  const std::string name = ptsname(terminal);
  const Program program;
  const Outcome outcome =
      program.run(Words{"render", "seeds", "--out", "d"} + tiny_scene(), [&name] {
        const int side = open(name.c_str(), O_RDWR | O_NOCTTY);
        return side >= 0 && dup2(side, STDERR_FILENO) >= 0;
      });
  ASSERT_EQ(outcome.code, 0);
  std::string drawn(1 << 16, '\0');
  fcntl(terminal, F_SETFL, O_NONBLOCK);
  const ssize_t bytes = read(terminal, drawn.data(), drawn.size());
  close(terminal);
  drawn.resize(bytes > 0 ? static_cast<std::size_t>(bytes) : 0);
  EXPECT_THAT(drawn, AllOf(HasSubstr("\r\033[Krender 000000 [....."), HasSubstr("] 0/2"),
                           HasSubstr("dataset: d")));
}

}  // namespace
}  // namespace cousin
