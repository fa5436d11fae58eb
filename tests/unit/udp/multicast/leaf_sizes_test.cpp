// These tests compare estimated sizes of projections with the sizes of real projections. The estimates are
// computed from the sizes of fields.
#include "udp_transport/multicast/leaf_sizes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "sft/detail/project.h"
#include "tests/support/test_seed.h"
#include "tests/unit/udp/messages.h"
#include "udp_transport/multicast/body_sizes.h"

namespace sft::udp {

namespace test {

/// An element with padding between its members, a string and a sequence.
struct Thing {
  std::uint8_t small = 0;
  double large = 0;
  std::string name;
  std::vector<std::uint16_t> numbers;
  std::uint8_t last = 0;
};
/// An element of fixed length.
struct Point {
  std::uint8_t ring = 0;
  double x = 0;
  std::uint16_t intensity = 0;
};
struct Scene {
  std::uint8_t first = 0;
  std::vector<Thing> things;
  std::uint8_t second = 0;
  std::vector<Point> points;
  std::vector<std::string> words;
  double third = 0;
};

}  // namespace test

}  // namespace sft::udp

template <>
struct sft::detail::TypeTable<sft::udp::test::Thing> {
  using T = sft::udp::test::Thing;
  static constexpr std::array members{
      member<std::uint8_t>("small", detail::Kind::uint8, offsetof(T, small)),
      member<double>("large", detail::Kind::float64, offsetof(T, large)),
      member<std::string>("name", detail::Kind::string, offsetof(T, name)),
      member<std::vector<std::uint16_t>>("numbers", detail::Kind::uint16, offsetof(T, numbers)),
      member<std::uint8_t>("last", detail::Kind::uint8, offsetof(T, last))};
  static constexpr StructType type{"test::Thing", members};
};
template <>
struct sft::detail::TypeTable<sft::udp::test::Point> {
  using T = sft::udp::test::Point;
  static constexpr std::array members{
      member<std::uint8_t>("ring", detail::Kind::uint8, offsetof(T, ring)),
      member<double>("x", detail::Kind::float64, offsetof(T, x)),
      member<std::uint16_t>("intensity", detail::Kind::uint16, offsetof(T, intensity))};
  static constexpr StructType type{"test::Point", members};
};
template <>
struct sft::detail::TypeTable<sft::udp::test::Scene> {
  using T = sft::udp::test::Scene;
  static constexpr std::array members{
      member<std::uint8_t>("first", detail::Kind::uint8, offsetof(T, first)),
      member<std::vector<sft::udp::test::Thing>>("things", detail::Kind::structure, offsetof(T, things)),
      member<std::uint8_t>("second", detail::Kind::uint8, offsetof(T, second)),
      member<std::vector<sft::udp::test::Point>>("points", detail::Kind::structure, offsetof(T, points)),
      member<std::vector<std::string>>("words", detail::Kind::string, offsetof(T, words)),
      member<double>("third", detail::Kind::float64, offsetof(T, third))};
  static constexpr StructType type{"test::Scene", members};
};

namespace sft::udp {
namespace {

using test::Image;
using test::Scene;
using test::Wide;

/// A sample with an encoded value, in its own memory.
template <class T>
class Sample {
 public:
  explicit Sample(const T& value, FieldMask mask = test::fields<T>("*")) : mask_(std::move(mask)) {
    const TypeSupport& type = test::type_support<T>();
    index_.resize(type.index_slots());
    body_.resize(detail::encoded_size(type.type(), &value, mask_).bytes / 8 + 1);
    bytes_ = detail::encoded_size(type.type(), &value, mask_).bytes;
    detail::encode(type.type(), &value, mask_, std::as_writable_bytes(std::span(body_)).first(bytes_),
                   index_);
  }
  detail::SampleState state() const {
    return {.body = std::as_bytes(std::span(body_)).data(),
            .body_bytes = bytes_,
            .index = index_.data(),
            .mask = &mask_};
  }
  double projected(const FieldMask& fields) const {
    detail::Projection projection;
    EXPECT_TRUE(projection.project(state(), test::type_support<T>().type(), fields));
    return static_cast<double>(projection.bytes());
  }

 private:
  FieldMask mask_;
  std::vector<std::uint64_t> body_;
  std::vector<std::uint32_t> index_;
  std::uint32_t bytes_ = 0;
};

class LeafSizesTest : public sft::test::RandomTest {
 protected:
  template <class T>
  FieldMask some_fields() {
    const TypeSupport& type = test::type_support<T>();
    FieldMask fields = type.none();
    for (std::size_t leaf = 0; leaf < type.leaves(); ++leaf) {
      if (random() % 2 == 0) fields.insert(leaf);
    }
    return type.closed(fields);
  }
  std::string text(std::size_t most) { return std::string(random() % (most + 1), 'x'); }
  Scene scene(std::size_t things, std::size_t points, std::size_t words) {
    Scene scene;
    scene.things.resize(things);
    for (test::Thing& thing : scene.things) {
      thing.name = text(20);
      thing.numbers.resize(random() % 10);
    }
    scene.points.resize(points);
    for (std::size_t i = 0; i < words; ++i) scene.words.push_back(text(10));
    return scene;
  }
  /// Compares estimates for random fields of `value` with projections. `error_max` is in bytes.
  template <class T>
  void expect_close(const T& value, double error_max) {
    const Sample<T> sample(value);
    LeafSizes sizes(test::type_support<T>().type());
    sizes.measure(sample.state());
    for (int i = 0; i < 100; ++i) {
      const FieldMask fields = some_fields<T>();
      ASSERT_TRUE(sizes.known(fields));
      const double bytes = sample.projected(fields);
      ASSERT_NEAR(sizes.bytes(fields), bytes, error_max) << test::type_support<T>().format_mask(fields);
      computed += sizes.bytes(fields);
      projected += bytes;
    }
  }
  double computed = 0, projected = 0;  ///< the bytes of all comparisons so far
};

TEST_F(LeafSizesTest, AreExactWhereElementsHaveOneLength) {
  expect_close(test::make_image(1234), 0);
  expect_close(Wide{}, 0);
  for (const std::size_t points : {0U, 1U, 2U, 7U, 100U, 5001U}) expect_close(scene(0, points, 0), 0);
}

/// After a field of variable length, up to 7 bytes of padding precede the next member. Their standard
/// deviation is up to 2.3 bytes. An element has at most three such members, and one more follows each word.
/// The paddings of these members are not quite independent.
TEST_F(LeafSizesTest, AreOffByThePaddingBetweenThingsThatVaryAndRightOnAverage) {
  for (int i = 0; i < 200; ++i) {
    const std::size_t things = random() % 33, words = random() % 33;
    const double deviation = 2.3 * std::sqrt(static_cast<double>(3 * things + words));
    expect_close(scene(things, random() % 100, words), 16 + 7 * deviation);
  }
  EXPECT_NEAR(computed, projected, 0.02 * projected);
}

/// The estimates use only the first 32 elements. So the average length of names of up to 20 bytes has an
/// error of about a byte, and so has the average length of the sequences of numbers.
TEST_F(LeafSizesTest, FollowFromTheFirstElementsOfALongSequence) {
  for (int i = 0; i < 6; ++i) expect_close(scene(2000, 10'000, 3000), 2000 * 10 + 3000 * 3);
  EXPECT_NEAR(computed, projected, 0.05 * projected);
}

TEST_F(LeafSizesTest, AreKnownForFieldsThatHaveBeenSent) {
  LeafSizes sizes(test::type_support<Image>().type());
  EXPECT_TRUE(sizes.known(test::fields<Image>("height, stamp"))) << "each sample takes as much for these";
  EXPECT_FALSE(sizes.known(test::fields<Image>("name")));
  sizes.measure(Sample<Image>(test::make_image(100), test::fields<Image>("name, height")).state());
  EXPECT_TRUE(sizes.known(test::fields<Image>("name, width")));
  EXPECT_FALSE(sizes.known(test::fields<Image>("data")));
}

TEST_F(LeafSizesTest, LetANewValueCountForAQuarter) {
  LeafSizes sizes(test::type_support<Image>().type());
  const FieldMask data = test::fields<Image>("data");
  sizes.measure(Sample<Image>(test::make_image(100)).state());
  EXPECT_EQ(sizes.bytes(data), 104);
  sizes.measure(Sample<Image>(test::make_image(1000)).state());
  EXPECT_EQ(sizes.bytes(data), 104 + 225);
}

TEST_F(LeafSizesTest, StayAsTheyAreIfASampleIsMalformed) {
  LeafSizes sizes(test::type_support<Image>().type());
  const Sample<Image> sample(test::make_image(100));
  detail::SampleState cut = sample.state();
  cut.body_bytes = 9;  // the length of the name is missing
  sizes.measure(cut);
  EXPECT_FALSE(sizes.known(test::fields<Image>("name")));
}

/// The size of a part of a list of strings is estimated from the first strings.
TEST_F(LeafSizesTest, TellWhatAPartOfAListOfTextsHas) {
  const TypeSupport& type = test::type_support<Scene>();
  for (const char* asked : {"words[::3]", "words[10:20]", "words[3000:]", "third, words[:2000]"}) {
    const Selection part = test::selection_of<Scene>(asked);
    const Sample<Scene> sample(scene(0, 0, 3000));
    BodySizes sizes(type.type());
    sizes.follow(type, {&part, 1});
    sizes.measure(sample.state(), BodySizes::Time{std::chrono::seconds(1)});
    ASSERT_TRUE(sizes.known(part)) << asked;
    detail::Projection projection;
    ASSERT_TRUE(projection.project(sample.state(), detail::ProjectionPlan(type, part)));
    EXPECT_NEAR(sizes.bytes_of(part), static_cast<double>(projection.bytes()), 3000 * 3) << asked;
  }
}

}  // namespace
}  // namespace sft::udp
