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
}

TEST(Xml, SaysWhereItIsBroken) {
  for (const auto& [text, word] :
       std::vector<std::pair<const char*, const char*>>{
           {"", "no element"},
           {"x", "no element"},
           {"<a>\n<b>\n</a>", "line 3: not XML: '</b>' is missing"},
           {"<a>", "'</a>' is missing"},
           {"<a b>", "'='"},
           {"<a b=1>", "quote"},
           {"<a b='", "missing"},
           {"<a b='1' b='2'/>", "twice"},
           {"<a/><b/>", "more behind"},
           {"<a>&x;</a>", "entity"},
           {"<a>& b</a>", "entity"},
           {"<a", "ends within"},
           {"<!-- ", "-->"},
           {"<1a/>x", "more"}})
    ExpectError(ExitCode::kInput, {word}, [&, &t = text] { ParseXml(t); });
}

TEST(Xml, RefusesElementsThatAreTooDeep) {
  std::string deep;
  for (int k = 0; k < 100000; ++k) deep += "<a>";
  ExpectError(ExitCode::kInput, {"too deep"}, [&] { ParseXml(deep); });
}

}  // namespace
}  // namespace raygrid
