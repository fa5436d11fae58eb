// If a program reads an empty sample, or a field that a sample lacks, it ends with a message, in every build.
// Also tests the functions that may be called on an empty sample.
#include <gtest/gtest.h>

#include <sensor_msgs/msg/PointCloud2.hpp>
#include <utility>

#include "core/seam/buffer_pool.h"
#include "sft/detail/type_description.h"
#include "sft/dynamic.h"
#include "sft/sample.h"
#include "tests/unit/core/publish/port_logs.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

DynamicType cloud_type() { return DynamicType::parse(describe(TypeTable<PointCloud2>::type)).value(); }

constexpr const char* stopped =
    "sft: an empty sample of sensor_msgs::msg::PointCloud2 is read: take\\(\\) had nothing to give, or the "
    "sample was moved away; write `if \\(sample\\)` first";

TEST(EmptySampleTest, CopiesAndTextsAreErrorsThatSayThatItIsEmpty) {
  const std::string why = "the sample is empty: take() had nothing to give";
  EXPECT_EQ(Sample<PointCloud2>().to_owned().error().message, why);
  EXPECT_EQ(Sample<PointCloud2>().to_partial().error().message, why);
  const DynamicSample sample(cloud_type(), {});
  EXPECT_EQ(sample.to_yaml().error().message, why);
  EXPECT_EQ(sample.to_json().error().message, why);
}

TEST(EmptySampleTest, ItSaysThatItIsEmptyAndHasNoBytes) {
  const Sample<PointCloud2> sample;
  EXPECT_FALSE(sample);
  EXPECT_FALSE(sample.malformed());
  EXPECT_TRUE(sample.cdr().empty());
}

TEST(EmptySampleDeathTest, ReadingAFieldIsStoppedWithASentence) {
  const Sample<PointCloud2, F::width> declared;
  EXPECT_DEATH((void)declared->width(), stopped);
  EXPECT_DEATH((void)declared.mask(), stopped);
  const Sample<PointCloud2> whole;
  EXPECT_DEATH((void)whole->data(), stopped);
  EXPECT_DEATH((void)whole->points<float>("x"), stopped);
  const Sample<PointCloud2, recorded> recorded_one;
  EXPECT_DEATH((void)recorded_one->width(), stopped);
}

TEST(EmptySampleDeathTest, ReadingASampleThatWasMovedAwayIsStoppedWithASentence) {
  const auto memory = core::BufferPool::make(std::size_t{1} << 20);
  const TypeSupport& type = type_support<PointCloud2>();
  Sample<PointCloud2> from(
      untyped::Sample(core::test::make_sample(*memory, type).release(), type, {}, nullptr));
  const Sample<PointCloud2> to(std::move(from));
  EXPECT_TRUE(to);
  EXPECT_DEATH((void)from->width(), stopped);  // NOLINT(bugprone-use-after-move)
}

TEST(EmptySampleDeathTest, ReadingAFieldByNameIsStoppedWithASentence) {
  const DynamicSample sample(cloud_type(), {});
  EXPECT_DEATH((void)sample.view(), "sft: an empty sample is read: .*write `if \\(sample\\)` first");
  EXPECT_DEATH((void)sample.mask(), "sft: an empty sample is read: ");
}

TEST(EmptySampleDeathTest, ReadingARecordedFieldThatWasNotSentIsStoppedWithASentence) {
  const Optional<std::string_view> absent;
  EXPECT_DEATH((void)*absent,
               "sft: a field is read that the sample was sent without: write `if \\(field\\)`");
  EXPECT_DEATH((void)absent->size(), "sft: a field is read that the sample was sent without: ");
  EXPECT_THROW((void)absent.value(), std::bad_optional_access);
}

}  // namespace
}  // namespace sft
