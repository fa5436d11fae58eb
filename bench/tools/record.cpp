// Measures `sft record`: its processor time compared with that of memcpy and write for the same bytes, and
// its speed of writing compared with that of dd.
#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "bench/common/pair.h"
#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "bench/common/statistics.h"
#include "bench/tools/programs.h"
#include "bench/tools/tools.h"
#include "tests/support/temporary_directory.h"

namespace sft::bench {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double full_bound = 1.3;  // relative to memcpy and write
constexpr double xyz_bound = 0.35;  // relative to whole clouds
constexpr double rate_bound = 0.8;  // relative to dd
constexpr std::int64_t record_period_us = 50'000;

struct Recorded {
  double cpu_ms = none;   ///< processor time per sample
  double lost = none;     ///< the number of samples that are not in the file
  double bytes = 0;       ///< the size of the file
  double seconds = none;  ///< the time from the first sample until the file is on the disk
};

/// Records clouds until the publisher has ended. The file is kept.
Recorded recorded(const Clouds& clouds, const std::string& topic, const test::TemporaryDirectory& folder) {
  const std::string file = folder.path() / "run.mcap", output = folder.path() / "record.json";
  std::filesystem::remove(file);
  const Shared<Stage> stage;
  const pid_t recorder = start_sft(1, {"record", topic, "-o", file, "--memory-mb", "4000", "--json"}, output);
  const pid_t publisher = start_on_core(0, [&] { return publish_clouds(clouds, *stage); });
  wait_until([&] { return stage->begun_at.load() != 0; }, 25);
  const double before = cpu_s(recorder);
  const bool published = succeeds(publisher);
  const double cpu = cpu_s(recorder) - before;
  kill(recorder, SIGINT);
  const bool written = succeeds(recorder);
  const double seconds = static_cast<double>(now_ns() - stage->begun_at) / 1e9;
  const nlohmann::json summary = last_json(output);
  if (!published || !written || !summary.contains("written")) return {};
  const double came = summary["written"].get<double>();
  return {.cpu_ms = cpu * 1e3 / static_cast<double>(clouds.count),
          .lost = static_cast<double>(clouds.count) - came,
          .bytes = summary["file_bytes"].get<double>(),
          .seconds = seconds};
}

bool write_all(int file, const std::vector<std::byte>& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t written = ::write(file, bytes.data() + done, bytes.size() - done);
    if (written <= 0) return false;
    done += static_cast<std::size_t>(written);
  }
  return true;
}

/// Returns the processor time per sample in ms of a process that only copies samples and writes them.
double copying_ms(const Clouds& clouds, const test::TemporaryDirectory& folder) {
  // The number of samples in memory, which is too large for a cache
  constexpr std::size_t places = 8;
  const std::string path = folder.path() / "copy";
  const Shared<double> cpu_ms;
  *cpu_ms = none;
  succeeds(start_on_core(1, [&] {
    const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    const std::vector<std::byte> from(places * sent_cloud_bytes, std::byte{1});
    std::vector<std::byte> to(sent_cloud_bytes, std::byte{2});
    const std::int64_t begin = now_ns();
    const double before = cpu_s(getpid());
    for (std::uint64_t i = 0; i < clouds.count; ++i) {
      sleep_until(begin + static_cast<std::int64_t>(i) * clouds.period_us * 1000);
      std::memcpy(to.data(), from.data() + i % places * sent_cloud_bytes, to.size());
      if (!write_all(file, to)) return 1;
    }
    *cpu_ms = (cpu_s(getpid()) - before) * 1e3 / static_cast<double>(clouds.count);
    return 0;
  }));
  std::filesystem::remove(path);
  return *cpu_ms;
}

/// Returns the speed with which dd copies the file to the same disk, in GB/s.
double dd_rate(double bytes, const test::TemporaryDirectory& folder) {
  const std::int64_t begin = now_ns();
  const bool copied = succeeds(
      start_program(1,
                    {"dd", "if=" + (folder.path() / "run.mcap").string(),
                     "of=" + (folder.path() / "dd").string(), "bs=6M", "conv=fdatasync", "status=none"},
                    "/dev/null"));
  const double rate = bytes / static_cast<double>(now_ns() - begin);
  std::filesystem::remove(folder.path() / "dd");
  return copied ? rate : none;
}

}  // namespace

std::vector<Figure> record(const Scale& scale) {
  const test::TemporaryDirectory folder;
  const auto samples = static_cast<std::uint64_t>(scale.seconds * 1e6 / record_period_us);
  const Clouds paced{.count = samples, .period_us = record_period_us};
  const Clouds flood{.count = 4 * samples};  // 1 GB, so that the time to end the program hardly counts
  std::vector<double> full, xyz, copying, rate, dd, lost;
  for (int round = 0; round < scale.rounds; ++round) {
    const Recorded whole = recorded(paced, "cloud", folder);
    copying.push_back(copying_ms(paced, folder));
    const Recorded some = recorded(paced, "cloud{data{x,y,z}}", folder);
    const Recorded fast = recorded(flood, "cloud", folder);
    dd.push_back(dd_rate(fast.bytes, folder));
    full.push_back(whole.cpu_ms);
    xyz.push_back(some.cpu_ms);
    rate.push_back(fast.bytes / fast.seconds / 1e9);
    lost.push_back(whole.lost + some.lost + fast.lost);
  }
  return {{"record_full", median(full), "ms", median(copying), "memcpy and write", full_bound},
          {"record_xyz", median(xyz), "ms", median(full), "record_full", xyz_bound},
          {"record_rate", median(rate), "GB/s", median(dd), "dd, fdatasync", rate_bound, false, true},
          {"record_lost", std::ranges::max(lost), "", {}, "", 0}};
}

}  // namespace sft::bench
