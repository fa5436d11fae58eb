// Writes samples into files of MCAP, on a thread of its own.
//
// put() copies a sample and returns, so that no sample of a publisher is held while a disk is slow. What has
// no room in memory is lost, and counted. Files are split by size or time; each begins with the retained
// samples of all publishers. With a window, samples stay in memory until trigger() is called. Then a file is
// written with the window, and with what comes within a second. It goes on with the next trigger, if that
// comes within the length of the window.
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
    std::string path{};  ///< with a window or a split, a number is put in front of its extension
    recording::McapWriter::Options file{};
    /// For all samples in memory: those that are not written yet, those of the window, of which three
    /// quarters are used, and the retained ones.
    std::uint64_t memory_bytes = std::uint64_t{1} << 30;
    std::uint64_t split_bytes = 0;           ///< 0: no split
    std::chrono::nanoseconds split_time{0};  ///< 0: no split
    std::chrono::nanoseconds window{0};      ///< 0: everything is written
    recording::Texts about{};                ///< a metadata record of each file
  };
  struct Status {
    std::uint64_t samples = 0;  ///< messages in the files, without those of a chunk that is still open
    std::uint64_t bytes = 0;    ///< the size of all files
    std::vector<std::string> files{};
    std::string fault{};  ///< why nothing more is written; empty: all is well
    bool is_over = false;
  };

  /// The path of a file of such a recording; `number` counts its files.
  static std::string path_of(const Options& options, std::size_t number);

  explicit SampleWriter(Options options);
  ~SampleWriter();
  SampleWriter(const SampleWriter&) = delete;
  SampleWriter& operator=(const SampleWriter&) = delete;

  /// Returns the number of a channel for put(). `retained` is how many of its last samples belong to the
  /// beginning of each file. The identifiers of both records are chosen here.
  std::size_t add_channel(recording::Schema schema, recording::Channel channel, std::uint32_t retained);
  /// Copies the sample. `message.channel` is not used. Returns false if it is lost, because memory is full or
  /// nothing more can be written.
  bool put(std::size_t channel, const recording::Message& message);
  /// The samples of the channel that put() has accepted, and that a fault of the disk has kept out of the
  /// files. It is complete once Status::is_over is true.
  std::uint64_t lost(std::size_t channel) const;
  /// Writes the window, and what comes within a second of the log time `log_ns`. Not to be called without a
  /// window.
  void trigger(std::uint64_t log_ns);
  /// Says what was lost of each topic so far, for the metadata of the files.
  void set_losses(recording::Texts losses);
  /// Writes everything and closes the file. Returns at once; Status::is_over is true when it is done.
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
    Shared sample{};  ///< null: a trigger
    std::uint64_t trigger_ns = 0;
  };
  struct KnownChannel {
    recording::Schema schema;
    recording::Channel channel;
    std::uint32_t retained;
    std::uint64_t lost = 0;     ///< guarded by the mutex
    std::deque<Shared> last{};  ///< what was retained when the next file begins; only the thread uses it
  };
  /// The messages of a channel that the present file was given.
  struct Given {
    std::uint64_t again = 0;  ///< retained ones, which an earlier file has, too
    std::uint64_t once = 0;
  };
  /// The state that only the thread uses.
  struct State {
    std::optional<recording::McapWriter> file{};
    std::uint64_t closed_bytes = 0;  ///< the size of the files before this one
    std::uint64_t closed_samples = 0;
    std::map<std::size_t, Given> given{};  ///< by channel
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
  std::atomic<std::uint64_t> held_bytes_{0};  ///< of all samples in memory
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // The next ones are guarded by the mutex.
  std::deque<Queued> queue_{};
  std::deque<KnownChannel> channels_{};  ///< grows only
  recording::Texts losses_{};
  bool finishes_ = false;
  Status status_{};

  State state_{};
  std::thread thread_;  ///< the last member, since it uses the others
};

}  // namespace sft::tool
