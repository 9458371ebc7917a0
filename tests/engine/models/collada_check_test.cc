// SPDX-License-Identifier: Apache-2.0
#include "engine/models/collada_check.h"

#include <string>

#include <gmock/gmock.h>

namespace plumbline {
namespace {

using testing::HasSubstr;

/// A triangle with joints; the first `from` in it becomes `to`.
std::string With(const std::string& from = "", const std::string& to = "") {
  std::string text = R"(<?xml version="1.0"?><!DOCTYPE COLLADA><COLLADA>
<!-- <p>not read</p> <triangles count="99999999"> -->
<mesh><source id="s"><float_array id="a" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#a" count = '3' stride="3"><param name="X"/><param name="Y"/><param name="Z"/></accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p> 0 1
2</p></triangles><polylist count="1"><vcount>3</vcount><p>0 1 2</p></polylist></mesh>
<skin><source id="j"><Name_array id="n" count="2">one two</Name_array><technique_common>
<accessor source="#n" count="2"><param name="JOINT"/></accessor></technique_common></source>
<vertex_weights count="1"><input semantic="JOINT" source="#j" offset="0"/><vcount>1</vcount><v>-1 0</v>
</vertex_weights></skin><empty/></COLLADA>)";
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ColladaCheck, HasNothingAgainstAFileThatIsWhole) { EXPECT_EQ(ColladaProblem(With()), ""); }

TEST(ColladaCheck, RefusesIndicesThatAreNone) {
  EXPECT_THAT(ColladaProblem(With("0 1\n2", "0 1 ^2")), HasSubstr("<p> has '^2'"));
  EXPECT_THAT(ColladaProblem(With("0 1\n2", "0 1 4000000000")), HasSubstr("4000000000"));
  EXPECT_THAT(ColladaProblem(With("0 1\n2", "<!-- -->^")), HasSubstr("'^'"));
  EXPECT_THAT(ColladaProblem(With("0 1\n2", "<![CDATA[^]]>")), HasSubstr("'^'"));
  EXPECT_THAT(ColladaProblem(With("0 1\n2", "0 1 &#50;")), HasSubstr("'&#50;'"));
  EXPECT_THAT(ColladaProblem(With("<vcount>3", "<vcount>700 700")), HasSubstr("too many"));
}

TEST(ColladaCheck, RefusesCountsBeyondTheFile) {
  EXPECT_THAT(ColladaProblem(With("<triangles count=\"1\"", "<triangles count=\"4000000000\"")),
              HasSubstr("count of an element <triangles> is '4000000000'"));
  EXPECT_THAT(ColladaProblem(With("offset=\"0\"", "offset=\"-1\"")), HasSubstr("offset"));
  EXPECT_THAT(ColladaProblem(With("count=\"9\"", "count=\"0x9\"")), HasSubstr("'0x9'"));
}

TEST(ColladaCheck, RefusesToReadBeyondAnArray) {
  const char* shorter = "the array 'a' is shorter";
  EXPECT_THAT(ColladaProblem(With("count=\"9\"", "coun=\"9\"")), HasSubstr(shorter));
  EXPECT_THAT(ColladaProblem(With("stride=\"3\"", "stride=\"4\"")), HasSubstr(shorter));
  EXPECT_THAT(ColladaProblem(With("stride=\"3\"", "stride=\"3\" offset=\"1\"")),
              HasSubstr(shorter));
  EXPECT_THAT(ColladaProblem(With("<param name=\"X\"/>", "<param/><param/>")), HasSubstr(shorter));
  EXPECT_THAT(ColladaProblem(With("source=\"#s\"", "source=\"#j\"")), HasSubstr("of words"));
}

TEST(ColladaCheck, EndsWithATornText) {
  const std::string whole = With();
  for (std::size_t size = 0; size < whole.size(); ++size)
    (void)ColladaProblem(whole.substr(0, size));
}

}  // namespace
}  // namespace plumbline
