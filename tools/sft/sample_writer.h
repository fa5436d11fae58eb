// Writes samples into MCAP files, on its own thread.
//
// put() copies a sample and returns, so that samples of publishers are not held while the disk is slow.
// Samples for which there is no memory are lost, and counted. Files are split by size or time. Each file
// begins with the retained samples of all publishers. If a window is set, samples stay in memory until
// trigger() is called. Then the window and the samples of the following second are written to a file. If
// the next trigger comes within the length of the window, its samples are written to the same file.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tools/recording/mcap_writer.h"

namespace sft::tool {

class SampleWriter {
 public:
  struct Options {
    /// The path of the file; with a window or a split, each file has a number before its extension
    std::string path{};
    recording::McapWriter::Options file{};
    /// The limit for all samples in memory: samples that are not written yet, the window, which may use
    /// three quarters of the limit, and retained samples.
    std::uint64_t memory_bytes = std::uint64_t{1} << 30;
    std::uint64_t split_bytes = 0;  ///< the size at which a new file begins; 0: files are not split by size
    /// the duration after which a new file begins; 0: files are not split by time
    std::chrono::nanoseconds split_time{0};
    std::chrono::nanoseconds window{0};  ///< the length of the window; 0: everything is written
    recording::Texts about{};            ///< the metadata record that each file gets
  };
  struct Status {
    std::uint64_t samples = 0;  ///< messages in the files, without those of a chunk that is still open
    std::uint64_t bytes = 0;    ///< the size of all files
    std::vector<std::string> files{};
    std::string fault{};  ///< the reason why nothing more is written; empty: there was no fault
    bool is_over = false;
  };

  /// Returns the path of file number `number` of a recording, from 0.
  static std::string path_of(const Options& options, std::size_t number);

  explicit SampleWriter(Options options);
  ~SampleWriter();
  SampleWriter(const SampleWriter&) = delete;
  SampleWriter& operator=(const SampleWriter&) = delete;

  /// Adds a channel, and returns its number for put(). Each file begins with the last `retained` samples of
  /// the channel. The ids in both records are ignored and chosen here.
  std::size_t add_channel(recording::Schema schema, recording::Channel channel, std::uint32_t retained);
  /// Copies the sample. `message.channel` is ignored. Returns false if the sample is lost, because memory
  /// is full or nothing more can be written.
  bool put(std::size_t channel, const recording::Message& message);
  /// Returns the number of samples of the channel that put() has accepted, but that are not in the files
  /// because of a fault of the disk. The number is final once Status::is_over is true.
  std::uint64_t lost(std::size_t channel) const;
  /// Writes the window, and the samples that arrive within a second of the log time `log_ns`. REQUIRES: a
  /// window is set.
  void trigger(std::uint64_t log_ns);
  /// Sets the losses of each topic so far, which are written to the metadata of the files.
  void set_losses(recording::Texts losses);
  /// Makes the thread write all samples and close the file. Does not wait for that. Status::is_over becomes
  /// true when it is done.
  void finish();
  Status status() const;

 private:
  struct Sample {
    std::size_t channel;
    recording::Message message;
    std::unique_ptr<std::byte[]> data;
  };
  using Shared = std::shared_ptr<const Sample>;
  struct Queued {
    Shared sample{};  ///< null: the entry is a trigger
    std::uint64_t trigger_ns = 0;
  };
  struct KnownChannel {
    recording::Schema schema;
    recording::Channel channel;
    std::uint32_t retained;
    std::uint64_t lost = 0;  ///< guarded by the mutex
    /// samples that the publisher has retained at the beginning of the next file; used by the thread only
    std::deque<Shared> last{};
  };
  /// The number of messages of a channel that were passed to the present file.
  struct Given {
    std::uint64_t again = 0;  ///< retained samples that an earlier file has, too
    std::uint64_t once = 0;
  };
  /// State that is used by the thread only.
  struct State {
    std::optional<recording::McapWriter> file{};
    std::uint64_t closed_bytes = 0;  ///< the size of the files before this one
    std::uint64_t closed_samples = 0;
    std::map<std::size_t, Given> given{};  ///< numbers of messages, by channel
    std::uint64_t begin_ns = 0;            ///< the log time of the file's first sample
    recording::Texts written_losses{};
    std::deque<Shared> window{};
    std::uint64_t trigger_ns = 0;  ///< the log time of the last trigger; 0: there was none
    std::uint64_t last_ns = 0;     ///< the log time of the last sample
    std::chrono::steady_clock::time_point flushed_at{};
  };

  void run();
  void take(const Shared& sample);
  void write_window(std::uint64_t trigger_ns);
  void shorten_window();
  void remember(const Shared& sample);
  void write(const Shared& sample);
  bool open_file(std::uint64_t log_ns);
  void write_to_file(std::size_t channel, recording::Message message);
  void count_lost(std::size_t channel, std::uint64_t samples);
  void write_losses();
  void flush();
  void close_file();
  void note(const Result<void>& done);
  bool has_failed() const;

  const Options options_;
  std::atomic<std::uint64_t> held_bytes_{0};  ///< the memory of all samples
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // The following members are guarded by the mutex.
  std::deque<Queued> queue_{};
  std::deque<KnownChannel> channels_{};  ///< channels are never removed
  recording::Texts losses_{};
  bool finishes_ = false;
  Status status_{};

  State state_{};
  std::thread thread_;  ///< must be the last member, since the thread uses the others
};

}  // namespace sft::tool
