#include "exchange/xml.h"

#include "support.h"

namespace raygrid {
namespace {

TEST(Xml, ReadsElementsAttributesAndText) {
  const XmlElement root = ParseXml(
      "<?xml version=\"1.0\"?>\n<!-- <no/> -->\n<a b=\"1 &lt; 2\" c='\"'>\n"
      " text &amp; <d/>more<d e=''>  inner\n</d>\n</a>\n<!-- end -->\n");
  EXPECT_EQ(root.name, "a");
  EXPECT_EQ(root.attributes.at("b"), "1 < 2");
  EXPECT_EQ(root.attributes.at("c"), "\"");
  EXPECT_EQ(root.text, "text & more");
  ASSERT_EQ(root.children.size(), 2u);
  EXPECT_EQ(root.children[1].text, "inner");
  EXPECT_EQ(root.children[1].line, 4);
  EXPECT_EQ(root.Child("d"), &root.children[0]);
  EXPECT_EQ(root.Child("x"), nullptr);
  EXPECT_EQ(ParseXml("<a><![CDATA[<b>]]>&#65;</a>").text, "<b>A");
}

TEST(Xml, SaysWhereItIsBroken) {
  for (const auto& [text, word] :
       std::vector<std::pair<const char*, const char*>>{
           {"", "no element"},
           {"x", "syntax error"},
           {"<a>\n<b>\n</a>", "line 3: not XML: mismatched tag"},
           {"<a><b>", "'</b>' is missing"},
           {"<a b>", "not well-formed"},
           {"<a b=1>", "not well-formed"},
           {"<a b='", "unclosed token"},
           {"<a b='1' b='2'/>", "duplicate attribute"},
           {"<a/>\n<b/>", "line 2: not XML: junk after document element"},
           {"<a>&x;</a>", "undefined entity"},
           {"<a>& b</a>", "not well-formed"},
           {"<a", "unclosed token"},
           {"<!-- ", "unclosed token"},
           {"<1a/>x", "not well-formed"},
           {"<!DOCTYPE a [<!ENTITY x 'y'>]>\n<a>&x;</a>", "document type"}})
    ExpectError(ExitCode::kInvalidInput, {word},
                [&, &t = text] { ParseXml(t); });
}

TEST(Xml, RefusesElementsThatAreTooDeep) {
  std::string deep;
  for (int k = 0; k < 100000; ++k) deep += "<a>";
  ExpectError(ExitCode::kInvalidInput, {"too deep"}, [&] { ParseXml(deep); });
}

}  // namespace
}  // namespace raygrid
