// Parts of fields with a layout rule of the user. The types are compiled from .msg and IDL, or the program
// gets them as text or as a description at run time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <layout_msgs/msg/HeightMap.hpp>
#include <layout_msgs/msg/Spectrum.hpp>
#include <layouts.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <string>
#include <vector>

#include "sft/detail/type_description.h"
#include "sft/detail/type_shape.h"
#include "sft/dynamic_type.h"
#include "sft/msg_text.h"
#include "tests/support/cut.h"
#include "tests/support/cut_reference.h"
#include "tests/support/random_layouts.h"

namespace sft {
namespace {

using layout_msgs::msg::HeightMap;
using layout_msgs::msg::Spectrum;
using test::Cut;
using test::cut_reference::indices;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using Part = Selection::Part;

template <class T>
Selection selected(std::string_view text) {
  return type_support<T>().parse_selection(text).value();
}

/// Returns a text such as "[rows 1:7:2, columns :5]".
std::string text_of(const Part& part) {
  const auto range = [](const Selection::Range& r) {
    if (r.is_empty()) return std::string("0:0");
    const std::string end = r.end == Selection::Range::no_end ? "" : std::to_string(r.end);
    return std::to_string(r.begin) + ":" + end + ":" + std::to_string(r.step);
  };
  return "[rows " + range(part.rows) + ", columns " + range(part.columns) + "]";
}

// ---- the content of a part, index by index ----

template <class Cell>
std::vector<Cell> window(const std::vector<Cell>& all, std::size_t rows, std::size_t columns,
                         const Part& part) {
  std::vector<Cell> kept;
  for (const std::size_t row : indices(part.rows, rows)) {
    for (const std::size_t column : indices(part.columns, columns))
      kept.push_back(all.at(row * columns + column));
  }
  return kept;
}

/// Computes the place of a cell's corner. The rotation is q v q*, with a quaternion q of length 1.
template <class Pose>
std::array<double, 3> corner_of(const Pose& pose, double x, double y) {
  using Quaternion = std::array<double, 4>;  // in the order w, x, y, z
  const auto times = [](const Quaternion& a, const Quaternion& b) {
    return Quaternion{a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                      a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                      a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
                      a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
  };
  const auto& q = pose.orientation;
  const Quaternion turned =
      times(times({q.w, q.x, q.y, q.z}, {0, x, y, 0}), Quaternion{q.w, -q.x, -q.y, -q.z});
  return {pose.position.x + turned[1], pose.position.y + turned[2], pose.position.z + turned[3]};
}

class UserLayoutTest : public test::RandomTest {
 protected:
  Part part(std::uint32_t rows, std::uint32_t columns) {
    Part part{.rows = layouts.range(rows), .columns = layouts.range(columns)};
    part.columns.step = part.rows.step;  // with different steps of rows and columns a map stays whole
    part.rows = part.rows.canonical();
    part.columns = part.columns.canonical();
    return part;
  }
  template <class Pose>
  void place(Pose& pose) {
    constexpr std::array<double, 2> turn{0.6, 0.8};
    pose.position.x = layouts.between(-100, 100);
    pose.position.y = layouts.between(-100, 100);
    pose.position.z = layouts.between(-1, 1);
    pose.orientation.z = turn[0];
    pose.orientation.w = turn[1];
  }
  template <class Cell>
  std::vector<Cell> cells(std::size_t count) {
    std::vector<Cell> cells(count);
    for (Cell& cell : cells) cell = static_cast<Cell>(layouts.below(30'000));
    return cells;
  }
  template <class Pose>
  static void expect_corner(const Pose& pose, const std::array<double, 3>& corner) {
    EXPECT_NEAR(pose.position.x, corner[0], 1e-9);
    EXPECT_NEAR(pose.position.y, corner[1], 1e-9);
    EXPECT_NEAR(pose.position.z, corner[2], 1e-9);
  }

  HeightMap map() {
    HeightMap m;
    m.header.frame_id = "map";
    m.rows = 1 + layouts.below(12);
    m.columns = 1 + layouts.below(12);
    m.resolution = 0.25F;
    place(m.origin);
    m.heights = cells<float>(std::size_t{m.rows} * m.columns);
    m.variances = cells<float>(m.heights.size());
    m.note = "of the yard";
    return m;
  }

  test::RandomLayouts layouts{random};
};

/// Expects `some` to equal that part of `whole`.
void expect_part(const HeightMap& whole, const Part& part, const HeightMap& some) {
  EXPECT_EQ(some.heights, window(whole.heights, whole.rows, whole.columns, part));
  EXPECT_EQ(some.rows, indices(part.rows, whole.rows).size());
  EXPECT_EQ(some.columns, indices(part.columns, whole.columns).size());
}

TEST_F(UserLayoutTest, APartOfAMessagesMapIsASmallerMapThatLiesWhereItLay) {
  for (int round = 0; round < 300; ++round) {
    const HeightMap whole = map();
    const Part wanted = part(whole.rows, whole.columns);
    if (wanted.is_whole() || wanted.rows.step != wanted.columns.step) continue;
    const std::string text = "heights" + text_of(wanted) + ", variances" + text_of(wanted) + ", note";
    const Cut<HeightMap> cut(whole, selected<HeightMap>(text));
    ASSERT_TRUE(cut.ok()) << text;
    const HeightMap some = cut.decoded();
    expect_part(whole, wanted, some);
    EXPECT_EQ(some.variances, window(whole.variances, whole.rows, whole.columns, wanted)) << text;
    EXPECT_EQ(some.note, whole.note);
    EXPECT_EQ(some.header.frame_id, "") << "nobody asked for it";
    EXPECT_FLOAT_EQ(some.resolution, whole.resolution * static_cast<float>(wanted.rows.step));
    const double size = whole.resolution;
    const double x = wanted.columns.begin * size, y = wanted.rows.begin * size;
    ASSERT_NO_FATAL_FAILURE((expect_corner(some.origin, corner_of(whole.origin, x, y))));
    if (HasFailure()) FAIL() << text << " in round " << round;
  }
}

TEST_F(UserLayoutTest, APartOfAMapInIdlHasItsSizeAndPlaceInAStructOfTheirOwn) {
  for (int round = 0; round < 300; ++round) {
    layouts::HeightMap whole;
    whole.level = 7;
    whole.raster.lines = 1 + layouts.below(9);
    whole.raster.width = 1 + layouts.below(9);
    whole.raster.cell = 0.1;
    place(whole.raster.corner);
    whole.heights = cells<std::int16_t>(std::size_t{whole.raster.lines} * whole.raster.width);
    const Part wanted = part(whole.raster.lines, whole.raster.width);
    if (wanted.is_whole() || wanted.rows.step != wanted.columns.step) continue;
    const Cut<layouts::HeightMap> cut(whole, selected<layouts::HeightMap>("heights" + text_of(wanted)));
    ASSERT_TRUE(cut.ok());
    const layouts::HeightMap some = cut.decoded();
    EXPECT_EQ(some.level, 7) << "a key is always sent";
    EXPECT_EQ(some.heights, window(whole.heights, whole.raster.lines, whole.raster.width, wanted));
    EXPECT_EQ(some.raster.lines, indices(wanted.rows, whole.raster.lines).size());
    EXPECT_EQ(some.raster.width, indices(wanted.columns, whole.raster.width).size());
    EXPECT_DOUBLE_EQ(some.raster.cell, 0.1 * wanted.rows.step);
    expect_corner(some.raster.corner,
                  corner_of(whole.raster.corner, 0.1 * wanted.columns.begin, 0.1 * wanted.rows.begin));
    if (HasFailure()) FAIL() << text_of(wanted) << " in round " << round;
  }
}

TEST_F(UserLayoutTest, AListIsWholeIfAKeyBelongsToItThatIsSentWhole) {
  StructType keyed = type_support<layouts::Spectrum>().type();
  std::vector<detail::Member> members(keyed.members.begin(), keyed.members.end());
  std::ranges::find(members, "phase", &detail::Member::name)->key = true;
  keyed.members = members;
  const TypeSupport type(keyed);
  const auto closed = [&](std::string_view text) { return type.closed(type.parse_selection(text).value()); };
  EXPECT_EQ(type.format_selection(closed("power[::2]")), "power, phase");
  EXPECT_EQ(type.closed(closed("power[::2]")), closed("power[::2]")) << "and stays so";
  EXPECT_EQ(closed("power[::2], phase[::2]").parts().size(), 2u);
}

TEST_F(UserLayoutTest, TheRuleHoldsWhereItsTypeIsAMemberOfAnotherOne) {
  layouts::Mission mission;
  mission.width = 77;
  mission.ground.raster.lines = mission.ground.raster.width = 2;
  mission.ground.heights = {1, 2, 3, 4};
  const Cut<layouts::Mission> cut(mission,
                                  selected<layouts::Mission>("width, ground.heights[rows 1, columns 1]"));
  ASSERT_TRUE(cut.ok());
  const layouts::Mission some = cut.decoded();
  EXPECT_THAT(some.ground.heights, ElementsAre(4));
  EXPECT_EQ(some.ground.raster.lines, 1U);
  EXPECT_EQ(some.width, 77U) << "another member of the same name stays";
}

TEST_F(UserLayoutTest, APartOfASpectrumSaysOfWhichFrequenciesItIs) {
  for (int round = 0; round < 300; ++round) {
    Spectrum whole;
    whole.first_frequency = 100.5;
    whole.frequency_step = 0.5F;
    whole.power = cells<double>(layouts.below(40));
    whole.last_frequency = 1e9;  // last_frequency must be ignored
    const Selection::Range range = layouts.range_with_some(40);
    if (range.is_all()) continue;
    const std::vector<std::size_t> kept = indices(range, whole.power.size());
    const std::string text = "power[" + std::to_string(range.begin) + ":" +
                             (range.end == Selection::Range::no_end ? "" : std::to_string(range.end)) + ":" +
                             std::to_string(range.step) + "]";
    const Cut<Spectrum> cut(whole, selected<Spectrum>(text));
    ASSERT_TRUE(cut.ok());
    const Spectrum some = cut.decoded();
    ASSERT_EQ(some.power.size(), kept.size()) << text;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      ASSERT_EQ(some.power[i], whole.power[kept[i]]);
      const double frequency = some.first_frequency + static_cast<double>(i) * some.frequency_step;
      ASSERT_DOUBLE_EQ(frequency, 100.5 + 0.5 * static_cast<double>(kept[i])) << text;
    }
    if (!kept.empty()) {
      ASSERT_DOUBLE_EQ(some.last_frequency, 100.5 + 0.5 * static_cast<double>(kept.back()));
    }
  }
}

TEST_F(UserLayoutTest, FieldsThatShareARuleHaveTheSamePartOrAreWhole) {
  layouts::Spectrum whole;
  whole.from = 10;
  whole.step = 2;
  whole.power = {0, 1, 2, 3, 4, 5};
  whole.phase = {0, 10, 20, 30, 40, 50};
  const auto part_of = [&](std::string_view text) {
    return Cut<layouts::Spectrum>(whole, selected<layouts::Spectrum>(text)).decoded();
  };
  const layouts::Spectrum both = part_of("power[1::2], phase[1::2]");
  EXPECT_THAT(both.power, ElementsAre(1, 3, 5));
  EXPECT_THAT(both.phase, ElementsAre(10, 30, 50));
  EXPECT_EQ(both.from, 12);
  EXPECT_EQ(both.step, 4);
  const layouts::Spectrum phase = part_of("phase[4:]");
  EXPECT_THAT(phase.phase, ElementsAre(40, 50));
  EXPECT_EQ(phase.from, 18);
  const layouts::Spectrum unlike = part_of("power[1:2], phase[2:3], from");
  EXPECT_EQ(unlike.power.size(), 6U);
  EXPECT_EQ(unlike.phase.size(), 6U);
  EXPECT_EQ(unlike.from, 10);
}

TEST_F(UserLayoutTest, MapsThatShareARuleHaveTheSameRowsOrAreWhole) {
  const HeightMap whole = map();
  const HeightMap some =
      Cut<HeightMap>(whole, selected<HeightMap>("heights[rows :1], variances[rows 1:2]")).decoded();
  EXPECT_EQ(some.heights, whole.heights);
  EXPECT_EQ(some.variances, whole.variances);
}

TEST_F(UserLayoutTest, APartOfRecordsHasNoGapsBetweenRows) {
  layouts::Records whole;
  whole.lines = 3;
  whole.width = 2;
  whole.record_bytes = 3;
  whole.line_bytes = 8;  // two bytes of each line are padding
  for (std::uint8_t i = 0; i < 24; ++i) whole.records.push_back(i);
  const Cut<layouts::Records> cut(whole, selected<layouts::Records>("records[rows ::2, columns 1:]"));
  ASSERT_TRUE(cut.ok());
  const layouts::Records some = cut.decoded();
  EXPECT_THAT(some.records, ElementsAre(3, 4, 5, 19, 20, 21));
  EXPECT_EQ(some.lines, 2U);
  EXPECT_EQ(some.width, 1U);
  EXPECT_EQ(some.record_bytes, 3U);
  EXPECT_EQ(some.line_bytes, 3U);
}

TEST_F(UserLayoutTest, PointsOfAnotherTypeHaveChannels) {
  layouts::Points whole;
  whole.width = 3;
  whole.point_bytes = 6;
  for (const auto& [name, offset, type, count] :
       {std::tuple<const char*, std::uint32_t, std::uint8_t, std::uint32_t>{"a", 0, 4, 1},
        {"b", 2, 2, 1},
        {"c", 4, 4, 1}}) {
    layouts::Channel& channel = whole.channels.emplace_back();
    channel.name = name;
    channel.offset = offset;
    channel.type = type;
    channel.count = count;
  }
  for (std::uint8_t i = 0; i < 18; ++i) whole.points.push_back(i);
  const Cut<layouts::Points> cut(whole, selected<layouts::Points>("points{b,c}[::2]"));
  ASSERT_TRUE(cut.ok());
  const layouts::Points some = cut.decoded();
  EXPECT_THAT(some.points, ElementsAre(2, 4, 5, 14, 16, 17));
  EXPECT_EQ(some.width, 2U);
  EXPECT_EQ(some.point_bytes, 3U);
  ASSERT_EQ(some.channels.size(), 2U);
  EXPECT_EQ(some.channels[0].name + some.channels[1].name, "bc");
  EXPECT_EQ(some.channels[1].offset, 1U);
}

TEST_F(UserLayoutTest, AMapThatContradictsItselfGivesAnEmptyPart) {
  HeightMap whole = map();
  whole.rows = whole.columns = 0x1'0000;
  for (const char* text : {"heights[rows 1:]", "heights[columns 1:]"}) {
    const HeightMap some = Cut<HeightMap>(whole, selected<HeightMap>(text)).decoded();
    EXPECT_THAT(some.heights, IsEmpty());
    EXPECT_EQ(some.rows, 0U);
    EXPECT_EQ(some.columns, 0U);
  }
}

// ---- types that are known only by text or description ----

/// Encodes a message of a compiled type. Returns the part of the message that `text` names, cut by `type`,
/// which is not compiled.
template <class T>
std::vector<std::byte> part_by(const DynamicType& type, const T& message, std::string_view text) {
  const TypeSupport& support = type.support();
  const detail::ProjectionPlan plan(support, support.closed(support.parse_selection(text).value()));
  const test::Encoded encoded(message);
  detail::Projection projection;
  EXPECT_TRUE(projection.project(encoded.state(), plan));
  return test::gathered(projection);
}

TEST_F(UserLayoutTest, ATypeFromItsDescriptionTakesTheSameParts) {
  const HeightMap whole = map();
  const auto type = DynamicType::parse(detail::describe(type_support<HeightMap>().type()));
  ASSERT_TRUE(type) << type.error().message;
  const std::string text = "heights[rows 2:4, columns ::2], note";
  EXPECT_EQ(part_by(*type, whole, text), Cut<HeightMap>(whole, selected<HeightMap>(text)).bytes());
  EXPECT_EQ(type->support().parse_selection(text).value(), selected<HeightMap>(text));
}

TEST_F(UserLayoutTest, ATypeFromTextTakesTheSamePartsAndItsTextHasTheRule) {
  const HeightMap whole = map();
  const auto compiled = DynamicType::parse(detail::describe(type_support<HeightMap>().type())).value();
  const std::string text = to_msg(compiled).value();
  EXPECT_THAT(text, HasSubstr("float32[] heights  # [m] @sft_layout rows=rows columns=columns "
                              "scale=resolution origin=origin also=variances\n"));
  const auto type = from_msg("layout_msgs/HeightMap", text);
  ASSERT_TRUE(type) << type.error().message;
  EXPECT_EQ(detail::format_shape(type->type()), detail::format_shape(compiled.type()));
  const std::string selection = "heights[rows 1:, columns 1:], variances[rows 1:, columns 1:]";
  EXPECT_EQ(part_by(*type, whole, selection), Cut<HeightMap>(whole, selected<HeightMap>(selection)).bytes());
  EXPECT_THAT(to_msg(DynamicType::parse(detail::describe(type_support<Spectrum>().type())).value()).value(),
              HasSubstr("float64[] power  # [dB] @sft_layout first=first_frequency"));
}

TEST_F(UserLayoutTest, AShapeShowsTheRule) {
  EXPECT_THAT(
      detail::format_shape(type_support<layouts::HeightMap>().type()),
      HasSubstr("@unit(\"mm\") @sft_layout(\"rows=raster.lines columns=raster.width scale=raster.cell "
                "origin=raster.corner\") sequence<int16> heights;"));
}

// ---- the identity of types and parts ----

DynamicType list_with(const std::string& rule) {
  const std::string comment = rule.empty() ? "" : "  # @sft_layout " + rule;
  return from_msg("my_msgs/List", "uint32 w\nuint32 h\nfloat32[] cells" + comment + "\n").value();
}

TEST(RulesOfTypesTest, ARuleIsNoPartOfTheTypesIdentity) {
  const DynamicType without = list_with(""), with = list_with("rows=h columns=w");
  EXPECT_EQ(without.hash(), with.hash());
  EXPECT_EQ(detail::first_difference(without.type(), with.type()), "");
}

TEST(RulesOfTypesTest, APartSaysByWhichRuleItIsMeant) {
  const auto rule_of = [](const DynamicType& type) {
    return type.support().parse_selection("cells[1:]")->parts()[0].rule;
  };
  EXPECT_EQ(rule_of(list_with("")), 0U);
  EXPECT_NE(rule_of(list_with("columns=w")), 0U);
  EXPECT_NE(rule_of(list_with("columns=w")), rule_of(list_with("columns=h")));
  EXPECT_EQ(rule_of(list_with("rows=h columns=w")), rule_of(list_with(" columns=w  rows=h ")));
  EXPECT_EQ(selected<sensor_msgs::msg::LaserScan>("ranges[1:]").parts()[0].rule, 0U)
      << "types of ROS 2 are the same everywhere";
}

TEST(RulesOfTypesTest, PartsByDifferentRulesAreDifferentAndTheUnionIsTheWholeField) {
  const Selection one = list_with("columns=w").support().parse_selection("cells[1:]").value();
  const Selection other = list_with("columns=h").support().parse_selection("cells[1:]").value();
  EXPECT_NE(one, other);
  EXPECT_NE(one.parts_hash(), other.parts_hash());
  EXPECT_THAT(one.joined(other).parts(), IsEmpty());
  EXPECT_EQ(Selection::from_bytes(one.to_bytes(), 3).value(), one);
}

TEST(RulesOfTypesTest, AnAnnotationStandsInForTheRuleThatATypeOfRosHas) {
  const auto scan = [](const std::string& comment) {
    return from_msg("sensor_msgs/LaserScan",
                    "float32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
                    "float32 time_increment\nfloat32[] ranges" +
                        comment + "\nfloat32[] intensities\n")
        .value();
  };
  const detail::Layout* known = scan("").support().layout_of(4);
  ASSERT_NE(known, nullptr);
  const DynamicType annotated = scan(" # @sft_layout first=angle_min");
  const detail::Layout* own = annotated.support().layout_of(4);
  ASSERT_NE(own, nullptr);
  EXPECT_EQ(own->data.size(), 1U);
  EXPECT_FALSE((*own)[detail::LayoutRole::step]);
}

// ---- hostile descriptions ----

std::vector<std::byte> description(std::string_view rule, std::string_view other_rule = "") {
  using detail::Kind;
  using detail::Shape;
  const std::array<detail::Member, 4> members{
      detail::Member{.name = "w", .kind = Kind::uint32}, detail::Member{.name = "h", .kind = Kind::uint32},
      detail::Member{.name = "cells", .kind = Kind::uint8, .shape = Shape::sequence, .layout = rule},
      detail::Member{.name = "more", .kind = Kind::string, .shape = Shape::sequence, .layout = other_rule}};
  return detail::describe(StructType("a::B", members));
}

std::string refusal(std::string_view rule, std::string_view other_rule = "") {
  const auto type = DynamicType::parse(description(rule, other_rule));
  return type ? "" : type.error().message;
}

TEST(ForgedRulesTest, AreRefusedWithTheMemberThatHasThem) {
  EXPECT_EQ(refusal("rows=h columns=w"), "");
  EXPECT_THAT(refusal("columns=w rows=h"), HasSubstr("member 'cells' is not in its one spelling"));
  EXPECT_THAT(refusal("rows=h  columns=w"), HasSubstr("is not in its one spelling"));
  EXPECT_THAT(refusal("rows=h"), HasSubstr("the layout of member 'cells': rows needs columns"));
  EXPECT_THAT(refusal("columns=x"), HasSubstr("there is no member 'x'"));
  EXPECT_THAT(refusal("columns=cells"), HasSubstr("'cells' is not a single uint32"));
  EXPECT_THAT(refusal("columns=w.a.b.c"), HasSubstr("'w' is not a single struct"));
  EXPECT_THAT(refusal("columns=w", "columns=h"),
              HasSubstr("member 'more': a layout belongs to a sequence of"));
  EXPECT_THAT(refusal("\x1b[2J"), HasSubstr("this is no role"));
  EXPECT_THAT(refusal(std::string(300, 'x')), HasSubstr("a name of 300 bytes"));
}

TEST(ForgedRulesTest, ManyRulesAreRefusedBeforeTheyCostTime) {
  std::string text = "uint32 w0\n";
  for (int i = 0; i < 65; ++i) {
    const std::string n = std::to_string(i);
    text += "float32 f" + n + "\nuint8[] c" + n + " # @sft_layout first=f" + n + "\n";
  }
  EXPECT_THAT(from_msg("my_msgs/Many", text).error().message, HasSubstr("a struct has at most 64 layouts"));
}

class DamagedRulesTest : public test::RandomTest {};

TEST_F(DamagedRulesTest, GiveTypesOfWhichPartsCanBeTakenOrNone) {
  const std::vector<std::byte> whole = detail::describe(type_support<HeightMap>().type());
  HeightMap map;
  map.rows = map.columns = 4;
  map.heights.resize(16);
  const std::vector<std::byte> body = test::Encoded(map).bytes();
  int accepted = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::vector<std::byte> bytes = whole;
    for (int i = 0; i < 2; ++i) bytes[random() % bytes.size()] = static_cast<std::byte>(random() % 128);
    const auto type = DynamicType::parse(bytes);
    if (!type) continue;
    ++accepted;
    const TypeSupport& support = type->support();
    for (std::size_t leaf = 0; leaf < support.leaves(); ++leaf) {
      if (support.layout_of(leaf) == nullptr) continue;
      const Part part{.leaf = static_cast<std::uint32_t>(leaf), .rows = {1, 3, 1}, .columns = {0, 4, 2}};
      const Selection asked = support.closed(Selection::make(support.none(), {part}, {}).value());
      const FieldMask full = support.full();
      std::vector<std::uint32_t> index(support.index_slots());
      const detail::SampleState state{.body = body.data(),
                                      .body_bytes = static_cast<std::uint32_t>(body.size()),
                                      .index = index.data(),
                                      .mask = &full};
      if (detail::build_index(state, type->type(), index) != detail::WalkStatus::ok) continue;
      detail::Projection projection;
      EXPECT_TRUE(projection.project(state, detail::ProjectionPlan(support, asked)));
    }
  }
  EXPECT_GT(accepted, 0);
}

}  // namespace
}  // namespace sft
