// Fields may have the same names as members of views, masks and loans.
#include <gtest/gtest.h>

#include <ranges>
#include <views.hpp>

#include "sft/mask.h"
#include "sft/type_support.h"
#include "tests/support/encoded.h"

namespace sft {
namespace {

using namespace detail;

using test::Encoded;
using views::InSequences;
using views::Names;

Names names(int n) {
  Names names;
  names.size = n;
  names.bytes = {1, 2};
  names.data = {0.5};
  names.class_ = "class";
  names.begin = n + 1;
  names.end = n + 2;
  names.each = 0.25;
  names.view = {7};
  names.mask = n + 3;
  names.empty = true;
  names.contains = n + 4;
  return names;
}

template <class View>
void expect_names(const View& view, int n) {
  EXPECT_EQ(view.size(), n);
  EXPECT_EQ(view.bytes().size(), 2U);
  EXPECT_EQ(view.data()[0], 0.5);
  EXPECT_EQ(view.class_(), "class");
  EXPECT_EQ(view.begin(), n + 1);
  EXPECT_EQ(view.end(), n + 2);
  EXPECT_EQ(view.each(), 0.25);
  EXPECT_EQ(view.view()[0], 7);
  EXPECT_EQ(view.mask(), n + 3);
  EXPECT_TRUE(view.empty());
  EXPECT_EQ(view.contains(), n + 4);
}

TEST(NamesTest, OfRangesAndMasksAreGetters) {
  const Encoded encoded(names(1));
  expect_names(view_of<Names, all<Names>>(encoded.state()), 1);
}

TEST(NamesTest, AreGettersInElementsToo) {
  InSequences message;
  message.size = {names(1), names(2), names(3)};
  message.begin = {"a", "b"};
  message.end = {names(4)};
  message.each = {names(5), names(6)};
  message.view = names(7);
  const Encoded encoded(message);
  const auto view = view_of<InSequences, all<InSequences>>(encoded.state());
  expect_names(view.size()[2], 3);
  EXPECT_EQ(view.begin().back(), "b");
  expect_names(view.end().front(), 4);
  expect_names(view.each()[1], 6);
  expect_names(view.view(), 7);
  EXPECT_EQ(std::ranges::find(view.size(), 2, [](const auto& e) { return e.size(); }) - view.size().begin(),
            1);
}

TEST(NamesTest, AreNamesOfFields) {
  using Inner = InSequences::Field;
  EXPECT_EQ(to_string(Inner::size.size | Inner::size.each.size), "size.size, size[].size");
  EXPECT_EQ(to_string(Inner::each.each.each | Inner::view.mask), "each[].each, view.mask");
  EXPECT_EQ(to_string(Inner::data.each.data | Inner::begin | Inner::end.each.end),
            "data[].data, begin, end[].end");
  EXPECT_EQ(to_string(Names::Field::empty | Names::Field::words), "empty, words");
}

}  // namespace
}  // namespace sft
