#include "core/rig/yaml_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal {
namespace {

using testing::HasSubstr;

TEST(YamlTree, KeepsOrderAndLines) {
  const Expected<YamlNode> tree = parse_yaml("b: 1\n\na:\n  - x\n  - \"2\"\n", "f.yaml");
  ASSERT_TRUE(tree);
  ASSERT_EQ(tree->keys.size(), 2U);
  EXPECT_EQ(tree->keys[0].name, "b");
  EXPECT_EQ(tree->keys[1].line, 3);
  ASSERT_EQ(tree->items[1].items.size(), 2U);
  EXPECT_EQ(tree->items[1].items[1].line, 5);
  EXPECT_TRUE(tree->items[1].items[1].quoted);
  EXPECT_FALSE(tree->items[1].items[0].quoted);
}

TEST(YamlTree, RefusesDeepNesting) {
  const std::string deep = "a: " + std::string(2000, '[') + std::string(2000, ']') + "\n";
  const Expected<YamlNode> tree = parse_yaml(deep, "f.yaml");
  ASSERT_FALSE(tree);
  EXPECT_THAT(tree.error().message(), HasSubstr("nested deeper"));
}

TEST(YamlTree, RefusesAnAliasBomb) {
  const Expected<YamlNode> tree = parse_yaml("a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n", "f.yaml");
  ASSERT_FALSE(tree);
  EXPECT_EQ(tree.error().where, "f.yaml:1");
}

TEST(YamlTree, RefusesLongTextAndManyNodes) {
  YamlLimits limits;
  limits.max_bytes = 100;
  EXPECT_FALSE(parse_yaml(std::string(101, ' '), "f.yaml", limits));
  limits.max_nodes = 3;
  EXPECT_TRUE(parse_yaml("[1, 2]", "f.yaml", limits));
  EXPECT_FALSE(parse_yaml("[1, 2, 3]", "f.yaml", limits));
}

TEST(YamlTree, RefusesBinaryFilesAndOddKeys) {
  EXPECT_FALSE(parse_yaml(std::string("a\0b: 1", 6), "f.yaml"));
  EXPECT_FALSE(parse_yaml("[a, b]: 1\n", "f.yaml"));
  EXPECT_FALSE(parse_yaml("? {a: b}\n: 1\n", "f.yaml"));
}

TEST(NearestWord, FindsSlipsButNotStrangers) {
  const std::vector<std::string> known{"range", "rings", "type"};
  EXPECT_EQ(nearest_word("rnage", known), "range");
  EXPECT_EQ(nearest_word("ring", known), "rings");
  EXPECT_EQ(nearest_word("temperature", known), "");
}

}  // namespace
}  // namespace rigcal
