// Projection of bytes: the bytes that are copied, the bytes that are only referenced, and inputs that the
// runtime refuses.
#include "sft/detail/project.h"

#include <gtest/gtest.h>

#include <ctime>
#include <nav_msgs/msg/Odometry.hpp>
#include <numeric>
#include <proof.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/detail/decode.h"
#include "tests/support/encoded.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using test::Encoded;

template <class T>
class Projected {
 public:
  Projected(const T& value, const Mask<T>& mask)
      : mask_(support_.closed(FieldMask(mask))),
        source_(value),
        ok_(projection_.project(source_.state(), type, mask_)) {}

  bool ok() const { return ok_; }
  std::size_t segments() const { return projection_.segments().size(); }

  /// Returns the number of bytes that the projection references in the source instead of copying them.
  std::size_t referenced_bytes() const {
    std::size_t bytes = 0;
    for (const Segment& s : projection_.segments()) bytes += is_in_source(s) ? s.bytes : 0;
    return bytes;
  }

  T decoded() const {
    std::vector<std::byte> body;
    for (const Segment& s : projection_.segments()) body.insert(body.end(), s.data, s.data + s.bytes);
    const auto bytes = static_cast<std::uint32_t>(body.size());
    std::vector<std::uint32_t> index(slot_count(type));
    const SampleState state{.body = body.data(), .body_bytes = bytes, .index = index.data(), .mask = &mask_};
    T value;
    EXPECT_EQ(build_index(state, type, index), WalkStatus::ok);
    EXPECT_EQ(decode(state, type, &value), WalkStatus::ok);
    return value;
  }

 private:
  static constexpr const StructType& type = TypeTable<T>::type;

  bool is_in_source(const Segment& s) const {
    const SampleState& source = source_.state();
    return s.data >= source.body && s.data + s.bytes <= source.body + source.body_bytes;
  }

  TypeSupport support_{type};
  FieldMask mask_;
  Encoded source_;
  Projection projection_;
  bool ok_;
};

PointCloud2 cloud_with_data(std::size_t bytes) {
  PointCloud2 cloud;
  cloud.header.frame_id = "lidar";
  cloud.fields.resize(2);
  cloud.data.resize(bytes);
  std::iota(cloud.data.begin(), cloud.data.end(), std::uint8_t{1});
  return cloud;
}

TEST(ProjectionTest, LargeBlocksStayWhereTheyAre) {
  const Projected projected(cloud_with_data(reference_bytes_min), ~PointCloud2::Field::height);
  EXPECT_EQ(projected.referenced_bytes(), reference_bytes_min);
  // three segments: the bytes before the reference, the referenced bytes, and the bytes after them
  EXPECT_EQ(projected.segments(), 3U);
}

TEST(ProjectionTest, SmallBlocksAreCopiedIntoOneRun) {
  const Projected projected(cloud_with_data(reference_bytes_min - 1), ~PointCloud2::Field::height);
  EXPECT_EQ(projected.referenced_bytes(), 0U);
  EXPECT_EQ(projected.segments(), 1U);
}

std::vector<std::byte> joined(const Projection& projection) {
  std::vector<std::byte> bytes;
  for (const Segment& s : projection.segments()) bytes.insert(bytes.end(), s.data, s.data + s.bytes);
  return bytes;
}

TEST(ProjectionTest, OnePlanServesSourcesOfAnyMaskThatHasItsOwn) {
  using F = PointCloud2::Field;
  const PointCloud2 cloud = cloud_with_data(10);
  const Mask<PointCloud2> wanted = F::height | F::width | F::point_step | F::is_dense;
  const ProjectionPlan plan(TypeTable<PointCloud2>::type, FieldMask(wanted));
  const std::vector<std::byte> expected = Encoded(cloud, wanted).bytes();
  Projection projection;
  for (const Mask<PointCloud2>& source :
       {all<PointCloud2>, wanted, wanted | F::row_step, wanted | F::header}) {
    ASSERT_TRUE(projection.project(Encoded(cloud, source).state(), plan));
    EXPECT_EQ(joined(projection), expected);
  }
}

// The bytes of the strings that are left out are a multiple of 4, but only sometimes of 8.
TEST(ProjectionTest, ARunThatMovesByLessThanItsAlignmentIsCopiedLeafByLeaf) {
  using F = nav_msgs::msg::Odometry::Field;
  const Mask<nav_msgs::msg::Odometry> wanted = ~(F::header | F::child_frame_id);
  for (std::size_t length = 0; length < 20; ++length) {
    nav_msgs::msg::Odometry odometry;
    odometry.child_frame_id.assign(length, 'x');
    odometry.pose.pose.position.x = 1.5;
    odometry.twist.covariance[35] = 2.5;
    Projection projection;
    const Encoded source(odometry);
    ASSERT_TRUE(
        projection.project(source.state(), TypeTable<nav_msgs::msg::Odometry>::type, FieldMask(wanted)));
    EXPECT_EQ(joined(projection), Encoded(odometry, wanted).bytes());
  }
}

TEST(ProjectionTest, ARunThatLeadsOutsideIsRefused) {
  using F = PointCloud2::Field;
  Encoded source(cloud_with_data(10));
  const ProjectionPlan plan(TypeTable<PointCloud2>::type, FieldMask(F::height | F::width));
  for (const std::uint32_t offset :
       {source.state().body_bytes - 7, source.state().body_bytes, no_offset - 1}) {
    source.index()[3] = offset;
    EXPECT_FALSE(Projection().project(source.state(), plan));
  }
  source.index()[3] = (source.state().body_bytes - 8) & ~3U;
  EXPECT_TRUE(Projection().project(source.state(), plan));
}

TEST(ProjectionTest, NothingAskedForIsNoBytes) {
  const Projected projected(cloud_with_data(10), Mask<PointCloud2>{});
  EXPECT_TRUE(projected.ok());
  EXPECT_EQ(projected.segments(), 0U);
}

TEST(ProjectionTest, ElementsAtChangingDistancesAreCopiedOneByOne) {
  using F = proof::Misaligned::Field;
  proof::Misaligned message;
  for (int i = 0; i < 1000; ++i) message.pairs.push_back({1, 0.5 * i});
  const Projected projected(message, F::pairs.each.b | F::last);
  EXPECT_EQ(projected.referenced_bytes(), 0U);
  EXPECT_EQ(projected.decoded().pairs[999].b, 499.5);
}

/// Only a type that was made by hand can have elements without bytes. A visit of all four billion elements
/// would take a minute.
TEST(ProjectionTest, AHugeCountOfElementsWithoutBytesCostsNothing) {
  const std::vector<Member> nothing{{.name = "a", .kind = Kind::uint8, .shape = Shape::array, .count = 0},
                                    {.name = "b", .kind = Kind::uint8, .shape = Shape::array, .count = 0}};
  const StructType element("test::Nothing", nothing);
  const std::vector<Member> members{
      {.name = "elements", .kind = Kind::structure, .shape = Shape::sequence, .type = &element}};
  const StructType type("test::Several", members);
  const TypeSupport support(type);
  const std::uint32_t count = 0xFFFFFFFF, index = 0;
  alignas(8) std::byte body[4];
  std::memcpy(body, &count, sizeof count);
  const FieldMask full = support.full();
  const SampleState source{.body = body, .body_bytes = sizeof body, .index = &index, .mask = &full};
  Projection projection;
  const std::clock_t before = std::clock();
  EXPECT_TRUE(
      projection.project(source, ProjectionPlan(type, *support.parse_mask("elements.size elements[].a"))));
  EXPECT_LT(std::clock() - before, CLOCKS_PER_SEC);
  EXPECT_EQ(projection.bytes(), sizeof count);
}

TEST(ProjectionTest, OfASequenceInAnElementTheLengthAloneMayBeAskedFor) {
  using F = proof::Scene::Field;
  proof::Scene scene;
  scene.tracks.resize(2);
  scene.tracks[0].pairs.resize(3);
  scene.tracks[0].mark = 'x';
  scene.tracks[1].mark = 'y';
  const Projected projected(scene, F::tracks.each.pairs.size | F::tracks.each.mark);
  ASSERT_TRUE(projected.ok());
  const proof::Scene decoded = projected.decoded();
  EXPECT_EQ(decoded.tracks[0].pairs.size(), 3U);
  EXPECT_EQ(decoded.tracks[0].mark, 'x');
  EXPECT_EQ(decoded.tracks[1].mark, 'y');
}

TEST(ProjectionTest, ASourceWithoutAFieldThatIsAskedForIsRefused) {
  using F = PointCloud2::Field;
  const Encoded source(cloud_with_data(10), Mask<PointCloud2>(F::width));
  Projection projection;
  EXPECT_FALSE(projection.project(source.state(), TypeTable<PointCloud2>::type, FieldMask(F::height)));
}

TEST(ProjectionTest, ASourceWhoseLengthsLeadOutsideIsRefused) {
  using F = PointCloud2::Field;
  Encoded source(cloud_with_data(10));
  const std::uint32_t length = 1'000'000;
  for (const std::size_t slot : {2U, 5U, 9U}) {  // the slots of frame_id, fields and data
    Encoded changed(cloud_with_data(10));
    std::memcpy(changed.body() + changed.index()[slot], &length, sizeof length);
    Projection projection;
    EXPECT_FALSE(
        projection.project(changed.state(), TypeTable<PointCloud2>::type, FieldMask(all<PointCloud2>)))
        << slot;
  }
  EXPECT_TRUE(
      Projection().project(source.state(), TypeTable<PointCloud2>::type, FieldMask(F::data | F::fields)));
}

}  // namespace
}  // namespace sft
