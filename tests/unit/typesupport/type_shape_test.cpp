// Types in a form that people read.
#include "sft/detail/type_shape.h"
#include "sft/detail/type_description.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <proof.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <set>
#include <string>
#include <string_view>
#include <torture.hpp>
#include <utility>
#include <vector>

#include "sft/dynamic_type.h"
#include "tests/support/message_types.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using ::testing::HasSubstr;

TEST(TypeShapeTest, IsIdlWithEveryStructOnceAndBeforeItIsUsed) {
  EXPECT_EQ(format_shape(TypeTable<PointCloud2>::type),
            "struct builtin_interfaces::msg::Time {\n"
            "  @unit(\"s\") int32 sec;\n"
            "  @unit(\"ns\") uint32 nanosec;\n"
            "};\n"
            "\n"
            "struct std_msgs::msg::Header {\n"
            "  builtin_interfaces::msg::Time stamp;\n"
            "  string frame_id;\n"
            "};\n"
            "\n"
            "struct sensor_msgs::msg::PointField {\n"
            "  string name;\n"
            "  @unit(\"byte\") uint32 offset;\n"
            "  uint8 datatype;\n"
            "  uint32 count;\n"
            "};\n"
            "\n"
            "struct sensor_msgs::msg::PointCloud2 {\n"
            "  std_msgs::msg::Header header;\n"
            "  uint32 height;\n"
            "  uint32 width;\n"
            "  sequence<sensor_msgs::msg::PointField> fields;\n"
            "  boolean is_bigendian;\n"
            "  @unit(\"byte\") uint32 point_step;\n"
            "  @unit(\"byte\") uint32 row_step;\n"
            "  sequence<uint8> data;\n"
            "  boolean is_dense;\n"
            "};\n");
}

TEST(TypeShapeTest, HasUnitsKeysBoundsArraysAndEnumerators) {
  const std::string nested = format_shape(TypeTable<torture::Nested>::type);
  EXPECT_THAT(nested, HasSubstr("  @key @unit(\"m/s\") double speed;\n"));
  EXPECT_THAT(nested, HasSubstr("  sequence<string<8>, 4> short_texts;\n"));
  EXPECT_THAT(nested, HasSubstr("  string<8> short_texts[4];\n"));
  EXPECT_THAT(nested,
              HasSubstr("@bit_bound(32) enum torture::Color {\n  RED = 0,\n  GREEN = 1,\n  BLUE = 7,\n};\n"));
  EXPECT_THAT(nested, HasSubstr("  torture::Color paint;\n"));
}

TEST(TypeShapeTest, IsThatOfTheCompiledTypeAfterParsing) {
  for (const test::MessageType& type : test::all_types()) {
    EXPECT_EQ(format_shape(DynamicType::parse(describe(type.type())).value().type()),
              format_shape(type.type()));
  }
}

/// Compares definitions of one type. The first members are the same.
class FirstDifference : public ::testing::Test {
 protected:
  using Members = std::vector<Member>;

  /// Returns the first difference between the two definitions. Expects their hashes to differ exactly if
  /// there is a difference.
  static std::string between(const Members& here, const Members& there) {
    const StructType a("T", here), b("T", there);
    const std::string difference = first_difference(a, b);
    EXPECT_EQ(difference.empty(), structure_hash(a) == structure_hash(b)) << difference;
    return difference;
  }
  /// Returns copies of the member with a single changed property, each with the name of that property.
  static std::vector<std::pair<Member, std::string_view>> neighbours_of(const Member& original) {
    std::vector<std::pair<Member, std::string_view>> all;
    const auto add = [&](std::string_view what, const auto& change) {
      change(all.emplace_back(original, what).first);
    };
    add("key", [](Member& m) { m.key = !m.key; });
    add("name", [](Member& m) { m.name = "another"; });
    if (original.shape == Shape::single) add("shape", [](Member& m) { m.shape = Shape::sequence; });
    if (original.shape == Shape::sequence) add("bound", [](Member& m) { m.bound += 7; });
    if (original.shape == Shape::array) add("count", [](Member& m) { m.count += 1; });
    if (original.kind == Kind::string) add("length of strings", [](Member& m) { m.string_bound += 7; });
    if (original.kind == Kind::uint8) add("kind", [](Member& m) { m.kind = Kind::int8; });
    if (original.kind == Kind::float64) add("kind", [](Member& m) { m.kind = Kind::int64; });
    return all;
  }
  static Member one(std::string_view name, Kind kind = Kind::uint32) { return {.name = name, .kind = kind}; }
  static Member of(std::string_view name, Shape shape, const StructType& type) {
    return {.name = name, .kind = Kind::structure, .shape = shape, .type = &type};
  }
};

TEST_F(FirstDifference, OfATypeAndItselfIsNone) {
  for (const test::MessageType& type : test::all_types())
    EXPECT_EQ(first_difference(type.type(), type.type()), "");
}

TEST_F(FirstDifference, MayBeTheTypeOfAMember) {
  EXPECT_EQ(between({one("a")}, {one("a", Kind::uint64)}), "a: uint32 here, uint64 there");
  Member few = one("a");
  few.shape = Shape::sequence;
  EXPECT_EQ(between({one("a")}, {few}), "a: uint32 here, sequence<uint32> there");
  Member fewer = few;
  fewer.bound = 16;
  EXPECT_EQ(between({few}, {fewer}), "a: sequence<uint32> here, sequence<uint32, 16> there");
  Member three = one("a");
  three.shape = Shape::array;
  three.count = 3;
  EXPECT_EQ(between({three}, {fewer}), "a: uint32[3] here, sequence<uint32, 16> there");
  Member text = one("a", Kind::string);
  Member short_text = text;
  short_text.string_bound = 8;
  EXPECT_EQ(between({short_text}, {text}), "a: string<8> here, string there");
}

TEST_F(FirstDifference, IsNamedByItsPath) {
  const Members inner_here{one("offset")};
  const Members inner_there{one("offset", Kind::uint64)};
  const StructType here("P", inner_here);
  const StructType there("P", inner_there);
  EXPECT_EQ(between({of("fields", Shape::sequence, here)}, {of("fields", Shape::sequence, there)}),
            "fields[].offset: uint32 here, uint64 there");
  EXPECT_EQ(between({of("field", Shape::single, here)}, {of("field", Shape::single, there)}),
            "field.offset: uint32 here, uint64 there");
  EXPECT_EQ(between({of("fields", Shape::sequence, here)}, {of("fields", Shape::single, here)}),
            "fields: sequence<P> here, P there");
}

TEST_F(FirstDifference, MayBeAName) {
  EXPECT_EQ(between({one("a"), one("height")}, {one("a"), one("rows")}),
            "member 2 is 'height' here, 'rows' there");
  EXPECT_EQ(between({one("a"), one("b")}, {one("b"), one("a")}), "member 1 is 'a' here, 'b' there");
  const Members inner_here{one("sec")};
  const Members inner_there{one("seconds")};
  const StructType here("P", inner_here);
  const StructType there("P", inner_there);
  EXPECT_EQ(between({of("stamp", Shape::single, here)}, {of("stamp", Shape::single, there)}),
            "stamp: member 1 is 'sec' here, 'seconds' there");
}

TEST_F(FirstDifference, MayBeAMemberThatOnlyOneSideHas) {
  EXPECT_EQ(between({one("a")}, {one("a"), one("foo")}), "one more member 'foo' there");
  EXPECT_EQ(between({one("a"), one("foo")}, {one("a")}), "one more member 'foo' here");
  EXPECT_EQ(between({one("a"), one("b")}, {one("a"), one("foo"), one("b")}), "one more member 'foo' there");
  EXPECT_EQ(between({one("foo"), one("a")}, {one("a")}), "one more member 'foo' here");
}

TEST_F(FirstDifference, MayBeAKey) {
  Member key = one("id");
  key.key = true;
  EXPECT_EQ(between({key}, {one("id")}), "id: a key here, no key there");
}

TEST_F(FirstDifference, MayBeAnEnumerator) {
  const std::vector<Enumerator> rg{{"RED", 0}, {"GREEN", 1}};
  const std::vector<Enumerator> rv{{"RED", 0}, {"VERT", 1}};
  const std::vector<Enumerator> r2{{"RED", 2}, {"GREEN", 1}};
  const std::vector<Enumerator> rgb{{"RED", 0}, {"GREEN", 1}, {"BLUE", 2}};
  const auto colors = [&](const std::vector<Enumerator>& a, const std::vector<Enumerator>& b,
                          bool flags = false) {
    const EnumType here{"Color", false, a};
    const EnumType there{"Color", flags, b};
    Member x = one("color", Kind::int32);
    Member y = x;
    x.enumeration = &here;
    y.enumeration = &there;
    return between({x}, {y});
  };
  EXPECT_EQ(colors(rg, rv), "color: enumerator 2 is 'GREEN' here, 'VERT' there");
  EXPECT_EQ(colors(rg, r2), "color: enumerator 'RED' is 0 here, 2 there");
  EXPECT_EQ(colors(rg, rgb), "color: one more enumerator 'BLUE' there");
  EXPECT_EQ(colors(rg, rg, true), "color: an enumeration here, a bitmask there");
  EXPECT_EQ(colors(rg, rg), "");
  const EnumType type{"Color", false, rg};
  Member x = one("color", Kind::int32);
  x.enumeration = &type;
  EXPECT_EQ(between({x}, {one("color", Kind::int32)}), "color: Color (int32) here, int32 there");
}

TEST_F(FirstDifference, IsFoundExactlyWhereTheHashesDiffer) {
  for (const test::MessageType& a : test::all_types()) {
    for (const test::MessageType& b : test::all_types()) {
      EXPECT_EQ(first_difference(a.type(), b.type()).empty(),
                structure_hash(a.type()) == structure_hash(b.type()))
          << a.support->name() << " and " << b.support->name();
    }
  }
}

TEST_F(FirstDifference, IsFoundInEachMemberThatIsNotQuiteTheSame) {
  std::set<std::string_view> tried;
  for (const test::MessageType& type : test::all_types()) {
    const Members here(type.type().members.begin(), type.type().members.end());
    for (std::size_t i = 0; i < here.size(); ++i) {
      for (const auto& [neighbour, what] : neighbours_of(here[i])) {
        Members there = here;
        there[i] = neighbour;
        EXPECT_NE(between(here, there), "") << type.support->name() << ", " << here[i].name << ": " << what;
        tried.insert(what);
      }
    }
  }
  EXPECT_EQ(tried.size(), 7U) << "each kind of difference was there";
}

}  // namespace
}  // namespace sft
