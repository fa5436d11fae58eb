// Random parts of recorded clouds, scans and maps equal, byte by byte, the parts that the reference cuts.
// Cyclone DDS can read these parts. Needs the recordings, which are not in the repository
// (recorded_data.h).
#include <nav_msgs/msg/OccupancyGrid.h>
#include <sensor_msgs/msg/Image.h>
#include <sensor_msgs/msg/LaserScan.h>
#include <sensor_msgs/msg/PointCloud2.h>

#include <filesystem>
#include <span>
#include <vector>

#include "tests/support/cyclone_cdr.h"
#include "tests/support/grey_map.h"
#include "tests/support/recorded_data.h"
#include "tests/unit/typesupport/cut_law.h"

namespace sft {
namespace {

constexpr std::size_t encapsulation_bytes = 4;

class CutCorpusLaw : public CutLawTest {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(test::recorded_data()))
      GTEST_SKIP() << "there are no recordings in " << test::recorded_data();
  }

  /// Decodes the payload. Padding to a multiple of 4 bytes may follow the message.
  template <class T>
  static T decoded(const test::Payload& payload) {
    const StructType& type = detail::TypeTable<T>::type;
    const FieldMask full = type_support<T>().full();
    const std::span<const std::byte> body = std::span(payload).subspan(encapsulation_bytes);
    std::vector<std::uint32_t> index(detail::slot_count(type));
    const detail::SampleState state{.body = body.data(),
                                    .body_bytes = static_cast<std::uint32_t>(body.size()),
                                    .index = index.data(),
                                    .mask = &full};
    EXPECT_EQ(detail::build_index(state, type, index), detail::WalkStatus::ok);
    T message;
    EXPECT_EQ(detail::decode(state, type, &message), detail::WalkStatus::ok);
    return message;
  }
  PointCloud2 recorded_cloud(const char* file) {
    return decoded<PointCloud2>(test::read_recording(test::recorded_data() / file).value());
  }

  /// Returns a part with channels that the cloud has, and sometimes a channel that the cloud lacks.
  Part any_part_of(const PointCloud2& cloud) {
    Part part{.leaf = leaf<PointCloud2>("data"),
              .rows = layouts.range(cloud.height),
              .columns = layouts.range(cloud.width)};
    if (layouts.one_in(3)) return part;
    for (const auto& field : cloud.fields)
      if (layouts.one_in(2)) part.channels.push_back(field.name);
    if (layouts.one_in(5)) part.channels.push_back("lacking");
    return part;
  }

  /// Returns the whole message with only these parts, as Cyclone DDS reads it; null if Cyclone DDS cannot
  /// read it.
  template <class C, class T>
  static const C* read(test::CycloneReader& reader, const T& message, std::vector<Part> parts) {
    const Selection selection =
        Selection::make(FieldMask::full(type_support<T>().leaves()), std::move(parts), {}).value();
    const Cut<T> cut(message, selection);
    EXPECT_TRUE(cut.ok());
    return static_cast<const C*>(reader.deserialize(cut.bytes()));
  }

  void expect_parts_of_cloud(const PointCloud2& cloud, int rounds) {
    test::CycloneReader reader(sensor_msgs_msg_PointCloud2_desc);
    for (int round = 0; round < rounds && !HasFatalFailure(); ++round) {
      SCOPED_TRACE("round " + std::to_string(round));
      const Part part = any_part_of(cloud);
      expect_points(cloud, part);
      const auto* read_cloud = read<sensor_msgs_msg_PointCloud2>(reader, cloud, {part});
      ASSERT_NE(read_cloud, nullptr);
      EXPECT_EQ(std::uint64_t{read_cloud->height} * read_cloud->row_step, read_cloud->data._length);
    }
  }
  void expect_parts_of_map(const char* file, int rounds) {
    const test::GreyMap map = test::read_grey_map(test::recorded_data() / file).value();
    OccupancyGrid grid = test::grid_of(map, 0.05F);
    grid.info.origin.position.x = -12.5;
    grid.info.origin.orientation.z = std::sin(0.2);
    grid.info.origin.orientation.w = std::cos(0.2);
    const Image image = test::image_of(map);
    test::CycloneReader grids(nav_msgs_msg_OccupancyGrid_desc), images(sensor_msgs_msg_Image_desc);
    for (int round = 0; round < rounds && !HasFatalFailure(); ++round) {
      SCOPED_TRACE("round " + std::to_string(round));
      expect_cells(grid);
      expect_pixels(image);
      Part part{.leaf = leaf<OccupancyGrid>("data"),
                .rows = layouts.range_with_some(grid.info.height),
                .columns = layouts.range_with_some(grid.info.width)};
      part.columns.step = part.rows.step;
      const auto* read_grid = read<nav_msgs_msg_OccupancyGrid>(grids, grid, {part});
      ASSERT_NE(read_grid, nullptr);
      EXPECT_EQ(std::uint64_t{read_grid->info.height} * read_grid->info.width, read_grid->data._length);
      part.leaf = leaf<Image>("data");
      const auto* read_image = read<sensor_msgs_msg_Image>(images, image, {part});
      ASSERT_NE(read_image, nullptr);
      EXPECT_EQ(std::uint64_t{read_image->height} * read_image->step, read_image->data._length);
    }
  }
};

TEST_F(CutCorpusLaw, PartsOfOusterClouds) {
  for (const char* file : {"lidar3d/ouster/pointcloud2_0.cdr", "lidar3d/ouster/pointcloud2_1.cdr.xz",
                           "lidar3d/ouster/pointcloud2_2.cdr.xz"}) {
    SCOPED_TRACE(file);
    expect_parts_of_cloud(recorded_cloud(file), 12);
  }
}

TEST_F(CutCorpusLaw, PartsOfACloudWithAnUnalignedTime) {
  expect_parts_of_cloud(recorded_cloud("cdr/pointcloud2_dds_message.bin"), 60);
}

TEST_F(CutCorpusLaw, PartsOfSmallClouds) {
  for (const test::Payload& payload : test::read_records(
           test::recorded_data() / "rosbag2/extracted/neato_obstacle-avoider__projected_stable_scan.cdrlog"))
    expect_parts_of_cloud(decoded<PointCloud2>(payload), 2);
}

TEST_F(CutCorpusLaw, PartsOfScans) {
  test::CycloneReader reader(sensor_msgs_msg_LaserScan_desc);
  for (const test::Payload& payload :
       test::read_records(test::recorded_data() / "rosbag2/extracted/neato_obstacle-avoider__scan.cdrlog")) {
    const LaserScan scan = decoded<LaserScan>(payload);
    expect_beams(scan);
    ASSERT_FALSE(HasFatalFailure());
    const Selection::Range range = layouts.range(static_cast<std::uint32_t>(scan.ranges.size()));
    const auto* read_scan =
        read<sensor_msgs_msg_LaserScan>(reader, scan,
                                        {{.leaf = leaf<LaserScan>("ranges"), .columns = range},
                                         {.leaf = leaf<LaserScan>("intensities"), .columns = range}});
    ASSERT_NE(read_scan, nullptr);
    EXPECT_EQ(read_scan->ranges._length, range.size_of(static_cast<std::uint32_t>(scan.ranges.size())));
    EXPECT_EQ(read_scan->intensities._length, read_scan->ranges._length);
  }
}

TEST_F(CutCorpusLaw, PartsOfMaps) {
  for (const char* file : {"maps/willow-full-0.05.pgm", "maps/depot.pgm", "maps/tb3_sandbox.pgm"}) {
    SCOPED_TRACE(file);
    expect_parts_of_map(file, 40);
  }
}

}  // namespace
}  // namespace sft
