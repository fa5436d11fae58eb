// Tests of the paths that --input accepts or refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/demo/clouds.h"
#include "tools/demo/clouds/point_cloud_files.h"

namespace sft::demo {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

class InputTest : public testing::Test {
 protected:
  static std::string error_on(const std::filesystem::path& path) {
    const auto input = read_point_clouds(path, 100);
    return input ? "no error" : input.error().message;
  }
  static std::vector<std::string> shapes(const Input& input) {
    std::vector<std::string> shapes;
    for (const InputCloud& cloud : input.clouds) shapes.push_back(cloud.shape);
    return shapes;
  }

  TemporaryDirectory directory_;
};

TEST_F(InputTest, MayBeAFile) {
  const auto input = read_point_clouds(directory_.write("a.cdr", payload_of(small_cloud(5))), 100);
  ASSERT_TRUE(input) << input.error().message;
  EXPECT_THAT(shapes(*input), ElementsAre("5 points"));
  EXPECT_THAT(input->notes, ElementsAre("read a.cdr"));
}

TEST_F(InputTest, MayBeADirectoryWhichIsReadInTheOrderOfTheNames) {
  directory_.write("2.cdr", payload_of(small_cloud(2)));
  directory_.write("1.cdr", payload_of(small_cloud(1)));
  directory_.write("3.cdrlog", record_of(payload_of(small_cloud(3))));
  directory_.write("notes.txt", bytes_of("not a cloud"));
  const auto input = read_point_clouds(directory_.path(), 100);
  ASSERT_TRUE(input) << input.error().message;
  EXPECT_THAT(shapes(*input), ElementsAre("1 points", "2 points", "3 points"));
  EXPECT_THAT(input->notes, ElementsAre("read 1.cdr to 3.cdrlog (3 files)"));
}

TEST_F(InputTest, PrefersMessagesToTheSamePointsInOtherFormatsAndSaysSo) {
  directory_.write("frame.bin", Bytes(16));
  directory_.write("cloud.cdr", payload_of(small_cloud(2)));
  directory_.write("more.cdr.xz", Bytes(10));
  const auto input = read_point_clouds(directory_.path(), 100);
  ASSERT_TRUE(input) << input.error().message;
  EXPECT_THAT(shapes(*input), ElementsAre("2 points"));
  EXPECT_THAT(input->notes,
              ElementsAre("read cloud.cdr", HasSubstr("(.xz) not used"), HasSubstr(".bin or .pcd")));
}

TEST_F(InputTest, IsNotReadFurtherThanNeeded) {
  directory_.write("1.cdr", payload_of(small_cloud(1)));
  directory_.write("2.cdr", bytes_of("damaged"));
  const auto input = read_point_clouds(directory_.path(), 1);
  ASSERT_TRUE(input) << input.error().message;
  EXPECT_THAT(input->notes, ElementsAre("read 1.cdr, which is enough: 1 more not used"));
}

TEST_F(InputTest, ThatIsDamagedIsNamed) {
  directory_.write("1.cdr", payload_of(small_cloud(1)));
  const auto damaged = directory_.write("2.cdr", bytes_of("damaged"));
  EXPECT_THAT(error_on(directory_.path()), StartsWith(damaged.native() + ": "));
}

TEST_F(InputTest, OfUnknownFormatIsNamedWithTheKnownOnes) {
  const auto unknown = directory_.write("cloud.las", Bytes(16));
  EXPECT_THAT(error_on(unknown),
              AllOf(StartsWith(unknown.native()), HasSubstr(".cdr, .cdrlog, .bin (KITTI) or .pcd")));
}

TEST_F(InputTest, ThatIsNotThereIsNamed) {
  EXPECT_THAT(error_on(directory_.path() / "none.cdr"), HasSubstr("none.cdr: no such file or directory"));
}

TEST_F(InputTest, ThatIsAnEmptyDirectoryIsRefused) {
  directory_.write("readme.txt", bytes_of("nothing here"));
  EXPECT_THAT(error_on(directory_.path()), HasSubstr("no .cdr, .cdrlog, .bin (KITTI) or .pcd file"));
}

TEST_F(InputTest, ThatIsNeitherFileNorDirectoryIsRefused) {
  const auto pipe = directory_.path() / "pipe.cdr";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const auto link = directory_.path() / "null.bin";
  std::filesystem::create_symlink("/dev/null", link);
  EXPECT_THAT(error_on(link), HasSubstr("neither a file nor a directory"));
  EXPECT_THAT(error_on(pipe), HasSubstr("neither a file nor a directory"));
}

TEST_F(InputTest, ThatIsEmptyIsRefused) {
  for (const char* name : {"a.cdr", "b.cdrlog", "c.bin", "d.pcd"}) {
    EXPECT_THAT(error_on(directory_.write(name, Bytes{})), HasSubstr(name));
  }
}

}  // namespace
}  // namespace sft::demo
