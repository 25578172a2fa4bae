#include "dataset/text_encoding.h"

#include "support.h"

namespace raygrid {
namespace {

TEST(FindInvalidUtf8, FindsTheFirstByteThatBelongsToNoText) {
  const std::string::size_type none = std::string::npos;
  for (const char* text : {"", "plain", "\xc3\xa9", "\xe2\x82\xac",
                           "\xf0\x9f\x93\xb7", "\xf4\x8f\xbf\xbf", "\x7f\n\t"})
    EXPECT_EQ(FindInvalidUtf8(text), none) << text;
  // Latin-1, a continuation alone, overlong forms, a surrogate, too large a
  // code, cut characters.
  for (const char* text :
       {"ab\xe9.png", "ab\x80", "ab\xc0\xaf", "ab\xe0\x80\xaf",
        "ab\xf0\x80\x80\xaf", "ab\xed\xa0\x80", "ab\xf4\x90\x80\x80",
        "ab\xf5\x80\x80\x80", "ab\xe2\x82", "ab\xc3"})
    EXPECT_EQ(FindInvalidUtf8(text), 2u) << text;
  EXPECT_EQ(FindInvalidUtf8(std::string("ab\0c", 4)), 2u);
}

TEST(Printable, LeavesTextAndEscapesWhatMovesATerminal) {
  EXPECT_EQ(Printable("caf\xc3\xa9 #1.png"), "caf\xc3\xa9 #1.png");
  EXPECT_EQ(Printable("a\nb"), "a\\nb");
  EXPECT_EQ(Printable("\x1b[31mred"), "\\x1b[31mred");
  EXPECT_EQ(Printable("caf\xe9"), "caf\\xe9");
  EXPECT_EQ(Printable("\xc2\x9b"
                      "1m"),
            "\\xc2\\x9b1m");
  EXPECT_EQ(Printable("\xe2\x80\xae"
                      "gnp"),
            "\\xe2\\x80\\xaegnp");
}

TEST(RequireTextFile, NamesTheLineOfWhatIsNoText) {
  EXPECT_NO_THROW(RequireTextFile("f.csv", "a\nb\n"));
  ExpectError(ExitCode::kInvalidInput, {"f.csv, line 2", "UTF-8"},
              [] { RequireTextFile("f.csv", "a\nb\xe9\n"); });
  for (const char* text : {"\xef\xbb\xbf"
                           "a",
                           "\xff\xfe"
                           "a",
                           "\xfe\xff"
                           "a"})
    ExpectError(ExitCode::kInvalidInput, {"f.csv", "byte order mark"},
                [&] { RequireTextFile("f.csv", text); });
}

}  // namespace
}  // namespace raygrid
