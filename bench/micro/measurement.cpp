#include "bench/micro/measurement.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <set>
#include <utility>

namespace sft::bench::micro {

namespace {

/// The times of each benchmark's repetitions.
using Times = std::map<std::string, std::vector<double>>;

/// Collects the times, and prints nothing.
class Collector : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
      std::vector<double>& of = times_[run.run_name.function_name];
      of.resize(std::max<std::size_t>(of.size(), static_cast<std::size_t>(run.repetition_index) + 1));
      of[static_cast<std::size_t>(run.repetition_index)] = run.GetAdjustedRealTime();
    }
  }
  const Times& times() const { return times_; }

 private:
  Times times_;
};

void enlist(const std::string& name, const Batch& batch, const Scale& scale) {
  constexpr benchmark::IterationCount at_a_time = 16;
  benchmark::RegisterBenchmark(name.c_str(),
                               [batch](benchmark::State& state) {
                                 while (state.KeepRunningBatch(at_a_time)) batch(at_a_time);
                               })
      ->Repetitions(scale.repetitions)
      ->MinTime(scale.repetition_s)
      ->UseRealTime();
}

std::string copy_of(std::size_t bytes) { return "memcpy_" + std::to_string(bytes); }

/// A memory block at the beginning of a cache line. The position of a copy within a cache line would affect
/// the time of a short copy.
struct alignas(64) CacheLine {
  std::byte bytes[64];
};

Batch copying(std::size_t bytes) {
  const std::size_t lines = bytes / sizeof(CacheLine) + 1;
  const auto from = std::make_shared<std::vector<CacheLine>>(lines);
  const auto to = std::make_shared<std::vector<CacheLine>>(lines);
  return batch_of([from, to, bytes] { std::memcpy(to->data(), from->data(), bytes); });
}

/// Passes settings to Google Benchmark, which applies them to all benchmarks like a command line.
void set_up() {
  static bool done = false;
  if (std::exchange(done, true)) return;
  std::vector<std::string> words{"bench_micro", "--benchmark_enable_random_interleaving=true"};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  auto count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);
  benchmark::Initialize(&count, arguments.data());
}

}  // namespace

std::vector<Measured> measure(const Operations& operations, const Scale& scale) {
  set_up();
  benchmark::ClearRegisteredBenchmarks();
  std::set<std::size_t> copied;
  for (const Operation& operation : operations) {
    enlist(operation.name, operation.batch, scale);
    if (copied.insert(operation.copied_bytes).second)
      enlist(copy_of(operation.copied_bytes), copying(operation.copied_bytes), scale);
  }
  Collector collector;
  benchmark::RunSpecifiedBenchmarks(&collector);
  std::vector<Measured> all;
  for (const Operation& operation : operations) {
    all.push_back({operation.name, operation.copied_bytes, collector.times().at(operation.name),
                   collector.times().at(copy_of(operation.copied_bytes))});
  }
  return all;
}

}  // namespace sft::bench::micro
