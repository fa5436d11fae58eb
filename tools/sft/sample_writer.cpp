#include "tools/sft/sample_writer.h"

#include <algorithm>
#include <filesystem>
#include <utility>

namespace sft::tool {

namespace {

using namespace std::chrono_literals;
using recording::McapWriter;

constexpr auto flush_period = 1s;  // the maximum time of samples that a killed process loses
constexpr std::uint64_t after_trigger_ns = 1'000'000'000;
constexpr std::size_t channels_most = UINT16_MAX;

/// Returns the path with a number before its extension: "run_3.mcap" for "run.mcap".
std::string numbered(const std::string& path, std::size_t number) {
  const std::filesystem::path whole(path);
  std::filesystem::path name = whole.stem();
  name += "_" + std::to_string(number);
  name += whole.extension();
  return (whole.parent_path() / name).string();
}

/// Returns the memory that a sample takes, with the overhead of the containers and the allocator.
std::uint64_t bytes_in_memory(std::size_t data, std::size_t sample) {
  constexpr std::uint64_t overhead = 64;
  return data + sample + overhead;
}

}  // namespace

std::string SampleWriter::path_of(const Options& options, std::size_t number) {
  const bool is_numbered =
      options.split_bytes != 0 || options.split_time.count() != 0 || options.window.count() != 0;
  return is_numbered ? numbered(options.path, number) : options.path;
}

SampleWriter::SampleWriter(Options options) : options_(std::move(options)), thread_([this] { run(); }) {}

SampleWriter::~SampleWriter() {
  finish();
  thread_.join();
}

std::size_t SampleWriter::add_channel(recording::Schema schema, recording::Channel channel,
                                      std::uint32_t retained) {
  const std::scoped_lock lock(mutex_);
  std::uint16_t schemas = 0;
  for (const KnownChannel& known : channels_) {
    schemas = std::max(schemas, known.schema.id);
    const bool is_same = known.schema.name == schema.name && known.schema.data == schema.data;
    if (is_same) schema.id = known.schema.id;
  }
  if (schema.id == 0) schema.id = static_cast<std::uint16_t>(schemas + 1);
  channel.schema = schema.id;
  channel.id = static_cast<std::uint16_t>(std::min(channels_.size() + 1, channels_most));
  channels_.push_back({std::move(schema), std::move(channel), retained});
  return channels_.size() - 1;
}

bool SampleWriter::put(std::size_t channel, const recording::Message& message) {
  const std::uint64_t bytes = bytes_in_memory(message.data.size(), sizeof(Sample));
  {
    const std::scoped_lock lock(mutex_);
    if (!status_.fault.empty() || held_bytes_ + bytes > options_.memory_bytes) return false;
  }
  held_bytes_ += bytes;
  const std::shared_ptr<Sample> sample(
      new Sample{channel, message, std::make_unique_for_overwrite<std::byte[]>(message.data.size())},
      [this, bytes](const Sample* unused) {
        delete unused;
        held_bytes_ -= bytes;
      });
  std::ranges::copy(message.data, sample->data.get());
  sample->message.data = {sample->data.get(), message.data.size()};
  const std::scoped_lock lock(mutex_);
  queue_.push_back({sample});
  changed_.notify_one();
  return true;
}

std::uint64_t SampleWriter::lost(std::size_t channel) const {
  const std::scoped_lock lock(mutex_);
  return channels_[channel].lost;
}

void SampleWriter::count_lost(std::size_t channel, std::uint64_t samples) {
  const std::scoped_lock lock(mutex_);
  channels_[channel].lost += samples;
}

void SampleWriter::trigger(std::uint64_t log_ns) {
  const std::scoped_lock lock(mutex_);
  queue_.push_back({.trigger_ns = log_ns});
  changed_.notify_one();
}

void SampleWriter::set_losses(recording::Texts losses) {
  const std::scoped_lock lock(mutex_);
  losses_ = std::move(losses);
}

void SampleWriter::finish() {
  const std::scoped_lock lock(mutex_);
  finishes_ = true;
  changed_.notify_one();
}

SampleWriter::Status SampleWriter::status() const {
  const std::scoped_lock lock(mutex_);
  return status_;
}

bool SampleWriter::has_failed() const {
  const std::scoped_lock lock(mutex_);
  return !status_.fault.empty();
}

void SampleWriter::note(const Result<void>& done) {
  const std::scoped_lock lock(mutex_);
  if (!done && status_.fault.empty()) status_.fault = done.error().message;
  status_.samples = state_.closed_samples + (state_.file ? state_.file->messages() : 0);
  status_.bytes = state_.closed_bytes + (state_.file ? state_.file->bytes() : 0);
}

// ---- functions of the writing thread ----

void SampleWriter::run() {
  for (bool is_over = false; !is_over;) {
    std::deque<Queued> batch;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, flush_period, [this] { return !queue_.empty() || finishes_; });
      batch.swap(queue_);
      is_over = finishes_ && batch.empty();
    }
    for (Queued& one : batch) {
      if (one.sample == nullptr)
        write_window(one.trigger_ns);
      else
        take(one.sample);
      one.sample.reset();
    }
    if (std::chrono::steady_clock::now() - state_.flushed_at >= flush_period) flush();
  }
  close_file();
  const std::scoped_lock lock(mutex_);
  status_.is_over = true;
}

void SampleWriter::take(const Shared& sample) {
  state_.last_ns = sample->message.log_ns;
  if (options_.window.count() == 0) return write(sample);
  // Simulated time may jump back.
  const std::uint64_t from_trigger_ns =
      std::max(state_.last_ns, state_.trigger_ns) - std::min(state_.last_ns, state_.trigger_ns);
  if (state_.trigger_ns != 0 && from_trigger_ns <= after_trigger_ns) return write(sample);
  state_.window.push_back(sample);
  shorten_window();
  const auto window_ns = static_cast<std::uint64_t>(options_.window.count());
  if (state_.file && from_trigger_ns > std::max(window_ns, after_trigger_ns)) close_file();
}

/// Removes samples from the window that are older than its length, or for which there is too little memory.
void SampleWriter::shorten_window() {
  const auto window_ns = static_cast<std::uint64_t>(options_.window.count());
  // New samples need memory, too
  const std::uint64_t most = options_.memory_bytes - options_.memory_bytes / 4;
  while (!state_.window.empty()) {
    const Shared& oldest = state_.window.front();
    const bool is_old = oldest->message.log_ns + window_ns < state_.last_ns;
    if (!is_old && held_bytes_ <= most) return;
    remember(oldest);
    state_.window.pop_front();
  }
}

/// Writes the window. `trigger_ns` is the time of the trigger, which counts instead of the time of the last
/// sample. That sample may be much older, and the sample that caused the trigger may arrive later, since
/// another subscriber receives it.
void SampleWriter::write_window(std::uint64_t trigger_ns) {
  state_.trigger_ns = std::max<std::uint64_t>(trigger_ns, 1);
  for (const Shared& sample : state_.window) write(sample);
  state_.window.clear();
}

/// Adds the sample to the samples that its publisher retains, and removes the oldest of these if there are
/// too many.
void SampleWriter::remember(const Shared& sample) {
  std::unique_lock lock(mutex_);
  KnownChannel& channel = channels_[sample->channel];
  lock.unlock();  // only this thread uses `last`, and elements of channels_ never move
  if (channel.retained == 0) return;
  channel.last.push_back(sample);
  if (channel.last.size() > channel.retained) channel.last.pop_front();
}

void SampleWriter::write(const Shared& sample) {
  const auto split_ns = static_cast<std::uint64_t>(options_.split_time.count());
  const std::uint64_t log_ns = sample->message.log_ns;
  if (state_.file && ((options_.split_bytes != 0 && state_.file->bytes() >= options_.split_bytes) ||
                      (split_ns != 0 && log_ns >= state_.begin_ns + split_ns)))
    close_file();
  if (!state_.file && (has_failed() || !open_file(log_ns))) return count_lost(sample->channel, 1);
  ++state_.given[sample->channel].once;
  write_to_file(sample->channel, sample->message);
  remember(sample);
}

bool SampleWriter::open_file(std::uint64_t log_ns) {
  std::unique_lock lock(mutex_);
  const std::string path = path_of(options_, status_.files.size());
  const std::size_t channels = channels_.size();
  lock.unlock();
  Result<McapWriter> file = McapWriter::create(path, options_.file);
  if (!file) {
    note(tl::unexpected(file.error()));
    return false;
  }
  state_.file.emplace(*std::move(file));
  state_.begin_ns = log_ns;
  state_.written_losses.clear();
  note(state_.file->write_metadata("sft_recording", options_.about));
  lock.lock();
  status_.files.push_back(path);
  lock.unlock();
  for (std::size_t i = 0; i < channels; ++i) {
    lock.lock();
    const std::deque<Shared>& retained = channels_[i].last;
    lock.unlock();
    for (const Shared& sample : retained) {
      recording::Message message = sample->message;
      message.log_ns = log_ns;  // the log time lies in this file; the time of publishing does not change
      ++state_.given[i].again;
      write_to_file(i, message);
    }
  }
  return true;
}

void SampleWriter::write_to_file(std::size_t channel, recording::Message message) {
  if (has_failed()) return;
  message.channel = static_cast<std::uint16_t>(channel + 1);
  if (!state_.file->has_channel(message.channel)) {
    const std::scoped_lock lock(mutex_);
    state_.file->declare(channels_[channel].schema);
    state_.file->declare(channels_[channel].channel);
  }
  note(state_.file->write(message));
}

void SampleWriter::write_losses() {
  recording::Texts losses;
  {
    const std::scoped_lock lock(mutex_);
    losses = losses_;
  }
  if (losses == state_.written_losses) return;
  note(state_.file->write_metadata("sft_losses", losses));
  state_.written_losses = std::move(losses);
}

void SampleWriter::flush() {
  state_.flushed_at = std::chrono::steady_clock::now();
  if (!state_.file || has_failed()) return;
  note(state_.file->flush());
  if (!has_failed()) write_losses();
}

void SampleWriter::close_file() {
  if (!state_.file) return;
  flush();
  const Result<void> done = state_.file->close();
  for (const auto& [channel, given] : state_.given) {
    // The first messages of a file are retained samples.
    const std::uint64_t written = state_.file->messages(static_cast<std::uint16_t>(channel + 1));
    count_lost(channel, std::min(given.once, given.again + given.once - written));
  }
  state_.given.clear();
  state_.closed_bytes += state_.file->bytes();
  state_.closed_samples += state_.file->messages();
  state_.file.reset();
  note(done);
}

}  // namespace sft::tool
