// The configuration file of sftd: its entries become settings. A wrong entry is refused, and the error names
// its line.
#include "shm_transport/sftd/config.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace sft::shm {
namespace {

using namespace std::chrono_literals;

/// A temporary file. The destructor removes it.
class File {
 public:
  explicit File(const std::string& text) {
    const int file = mkstemp(path_.data());
    EXPECT_EQ(write(file, text.data(), text.size()), static_cast<ssize_t>(text.size()));
    close(file);
  }
  ~File() { std::remove(path_.c_str()); }
  const std::string& path() const { return path_; }

 private:
  std::string path_ = "/tmp/sftd_config_XXXXXX";
};

Config read(const std::string& text) {
  const File file(text);
  const auto config = read_config(file.path());
  EXPECT_TRUE(config) << config.error().message;
  return config.value_or(Config{});
}

/// Returns the error message for a file with this text, without the name of the file.
std::string refusal(const std::string& text) {
  const File file(text);
  const auto config = read_config(file.path());
  if (config) return "accepted";
  EXPECT_TRUE(config.error().message.starts_with(file.path() + ":")) << config.error().message;
  return config.error().message.substr(file.path().size() + 1);
}

TEST(SftdConfig, AnEmptyFileLeavesTheDefaults) {
  const Config config = read("");
  EXPECT_FALSE(config.settings.pool_bytes);
  EXPECT_TRUE(config.settings.pools.empty());
  EXPECT_FALSE(config.log_level);
}

TEST(SftdConfig, TheMemoryIdleExitAndLogLevelAreRead) {
  const Config config = read("total_mib = 64\nidle_exit_s = 30\nlog_level = 'debug'");
  EXPECT_EQ(config.settings.pool_bytes, 64U << 20);
  EXPECT_EQ(config.settings.idle_exit, 30s);
  EXPECT_EQ(config.log_level, LogLevel::debug);
}

TEST(SftdConfig, PoolsAreReadAndSortedBySize) {
  const Config config = read("[[pool]]\nsize_kib = 1024\ncount = 4\n[[pool]]\nsize_kib = 4\ncount = 100");
  ASSERT_EQ(config.settings.pools.size(), 2U);
  EXPECT_EQ(config.settings.pools[0].bytes, 4U << 10);
  EXPECT_EQ(config.settings.pools[0].count, 100U);
  EXPECT_EQ(config.settings.pools[1].bytes, 1U << 20);
}

TEST(SftdConfig, LimitsAndGroupsAreRead) {
  const Config config =
      read("[limits]\nprocesses = 5\nsubscribers_per_process = 7\n[access]\nwriters = 'w'\nreaders = 'r'");
  EXPECT_EQ(config.settings.limits.processes, 5U);
  EXPECT_EQ(config.settings.limits.subscribers_per_process, 7U);
  EXPECT_EQ(config.settings.limits.publishers_per_process, Limits{}.publishers_per_process);
  EXPECT_EQ(config.settings.access.writers, "w");
  EXPECT_EQ(config.settings.access.readers, "r");
}

TEST(SftdConfig, TheInstalledFileHasTheDefaults) {
  const auto config = read_config(SFTD_TOML);
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->settings.idle_exit, DaemonSettings{}.idle_exit);
  EXPECT_EQ(config->settings.limits.processes, Limits{}.processes);
  EXPECT_EQ(config->log_level, LogLevel::info);
}

TEST(SftdConfig, AnUnknownKeyIsRefusedWithItsLineAndTheKnownKeys) {
  EXPECT_EQ(
      refusal("total_mib = 64\n\nidle_exit = 3"),
      "3: idle_exit: unknown key: use one of total_mib, pool, idle_exit_s, log_level, limits, access, or "
      "remove it");
  EXPECT_EQ(refusal("[access]\nwriters = 'w'\nreader = 'r'"),
            "3: access.reader: unknown key: use one of writers, readers, or remove it");
  EXPECT_EQ(refusal("[[pool]]\nsize_kib = 4\ncount = 2\nname = 'x'"),
            "4: pool.name: unknown key: use one of size_kib, count, or remove it");
}

TEST(SftdConfig, AWrongValueIsRefusedWithItsLineAndThePossibleValues) {
  EXPECT_EQ(refusal("\nidle_exit_s = -1"),
            "2: idle_exit_s: not a whole number from 0 to 1073741824: write for example idle_exit_s = 0");
  EXPECT_EQ(refusal("total_mib = '64'"),
            "1: total_mib: not a whole number from 4 to 1048576: write for example total_mib = 4");
  EXPECT_EQ(refusal("[limits]\nprocesses = 301"),
            "2: limits.processes: not a whole number from 1 to 300: write for example processes = 1");
  EXPECT_EQ(refusal("log_level = 'loud'"), "1: log_level: not a level: write error, warning, info or debug");
  EXPECT_EQ(refusal("log_level = 3"), "1: log_level: not a level: write error, warning, info or debug");
  EXPECT_EQ(refusal("[access]\nwriters = 3"), "2: access.writers: not a name: write writers = \"name\"");
}

TEST(SftdConfig, EntriesThatContradictEachOtherOrAreIncompleteAreRefused) {
  EXPECT_EQ(refusal("[[pool]]\nsize_kib = 4"), "1: pool.size_kib, count: one of them is missing: give both");
  EXPECT_EQ(refusal("[access]\nreaders = 'r'"),
            "1: access.writers: missing: name the group that may publish");
  EXPECT_EQ(refusal("total_mib = 64\n[[pool]]\nsize_kib = 4\ncount = 2"),
            "2: pool: the file has total_mib as well: remove one of the two");
  EXPECT_EQ(refusal("[[pool]]\nsize_kib = 4\ncount = 2\n[[pool]]\nsize_kib = 4\ncount = 3"),
            "1: pool: two pools have the same size_kib: join them");
}

TEST(SftdConfig, AValueInThePlaceOfASectionOrListIsRefused) {
  EXPECT_EQ(refusal("limits = 3"), "1: limits: not a section: write [limits]");
  EXPECT_EQ(refusal("pool = [4, 2]"), "1: pool: not a list of sizes: write [[pool]]");
}

TEST(SftdConfig, AFileThatIsNotTomlIsRefusedWithTheLine) {
  EXPECT_TRUE(refusal("total_mib = 64\nidle_exit_s =\n").starts_with("2: "))
      << refusal("x = 1\nidle_exit_s =\n");
  EXPECT_TRUE(refusal("total_mib = 4\ntotal_mib = 5").starts_with("2: "));
}

TEST(SftdConfig, TheErrorOfAFileThatCannotBeReadNamesTheFile) {
  EXPECT_TRUE(read_config("/nowhere/sftd.toml").error().message.starts_with("/nowhere/sftd.toml: "));
}

}  // namespace
}  // namespace sft::shm
