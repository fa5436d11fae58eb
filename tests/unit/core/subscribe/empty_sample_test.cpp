// A sample that is read although take() returned none: what assertions report, and what is read without
// assertions. The file is built both ways.
#include <gtest/gtest.h>

#include <sensor_msgs/msg/CameraInfo.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/detail/type_description.h"
#include "sft/dynamic.h"
#include "sft/sample.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

DynamicType cloud_type() { return DynamicType::parse(describe(TypeTable<PointCloud2>::type)).value(); }

#ifdef NDEBUG

TEST(EmptySampleTest, EveryFieldIsZeroOrEmptyAndTheSampleSaysThatItIsMalformed) {
  const Sample<PointCloud2> sample;
  EXPECT_FALSE(sample);
  EXPECT_EQ(sample->width(), 0U);
  EXPECT_EQ(sample->header().stamp().sec(), 0);
  EXPECT_EQ(sample->header().frame_id(), "");
  EXPECT_TRUE(sample->data().empty());
  for (const auto field : sample->fields()) FAIL() << field.name();
  EXPECT_TRUE(sample.malformed());
  EXPECT_TRUE(sample.mask().empty());
  EXPECT_TRUE(sample.cdr().empty());
}

TEST(EmptySampleTest, ArraysAreEmpty) {
  const Sample<CameraInfo> sample;
  EXPECT_TRUE(sample->k().empty() || sample->k()[0] == 0);
  EXPECT_TRUE(sample.malformed());
}

TEST(EmptySampleTest, FieldsThatAreRecordedAreAbsent) {
  const Sample<PointCloud2, recorded> sample;
  EXPECT_FALSE(sample->width());
  EXPECT_FALSE(sample->fields());
}

TEST(EmptySampleTest, FieldsThatAreReadByNameAreAbsent) {
  const DynamicSample sample(cloud_type(), {});
  EXPECT_TRUE(sample.view()["width"].is_absent());
  EXPECT_EQ(sample.view()["width"].as<int>().error().code, Errc::unavailable);
  EXPECT_TRUE(sample.mask().empty());
}

TEST(EmptySampleTest, CopiesAndTextsAreErrorsThatSayThatItIsEmpty) {
  const std::string why = "the sample is empty: take() had nothing to give";
  EXPECT_EQ(Sample<PointCloud2>().to_owned().error().message, why);
  EXPECT_EQ(Sample<PointCloud2>().to_partial().error().message, why);
  const DynamicSample sample(cloud_type(), {});
  EXPECT_EQ(sample.to_yaml().error().message, why);
  EXPECT_EQ(sample.to_json().error().message, why);
}

#else

TEST(EmptySampleDeathTest, ReadingAFieldIsStoppedWithASentence) {
  const Sample<PointCloud2, F::width> sample;
  EXPECT_DEATH((void)sample->width(), "an empty sample is read: ask `if \\(sample\\)` first");
  EXPECT_DEATH((void)sample.mask(), "an empty sample is asked for its mask");
}

TEST(EmptySampleDeathTest, ReadingAFieldByNameIsStoppedWithASentence) {
  const DynamicSample sample(cloud_type(), {});
  EXPECT_DEATH((void)sample.view(), "an empty sample is read: ask `if \\(sample\\)` first");
}

#endif

}  // namespace
}  // namespace sft
