#include "tools/sft/play.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <tuple>

#include "tools/recording/qos_profile.h"
#include "tools/sft/bag.h"
#include "tools/sft/keys.h"
#include "tools/sft/msg_text.h"
#include "tools/sft/played_files.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto late_most = 20ms;    // a longer delay is not caught up: all topics are delayed
constexpr auto behind_max = 1s;     // the user is warned once the sum of delays is larger
constexpr auto blocking_most = 1s;  // the time for which publishing may wait for slow reliable subscribers
constexpr auto last_pause = 200ms;  // time for the last sample to be received before the node closes
constexpr double ns_of_s = 1e9;
constexpr double most_ns = 1e17;         // three years: the limit of a wait for a message
constexpr double enough_of_rate = 0.98;  // a lower share is reported

/// A publisher in the recording, and the publisher that now publishes its samples.
struct PlayedChannel {
  std::string topic;
  DynamicPublisher publisher;
  /// The number of samples that the publisher retains for late readers; 0: it retains none
  std::uint32_t retained;
  std::uint64_t samples = 0;
  /// Identifies the last retained samples that were published. In a recording of several files, each file
  /// repeats the retained samples of earlier files. A sample is identified by its time of publishing, its
  /// number, and a hash of its contents, since SQLite files have no numbers.
  std::deque<std::tuple<std::uint64_t, std::uint32_t, std::size_t>> published{};
};

/// A file whose faults are reported while it is played.
struct ReportedFile {
  std::string path;
  std::size_t faults;  ///< the number of faults that were reported
};

/// Publishes the messages of files on their topics.
class Player {
 public:
  Player(const PlayOptions& options, const CommonOptions& common, Session& session,
         std::vector<std::unique_ptr<recording::Recording>> files, std::vector<ReportedFile> reported)
      : options_(options),
        common_(common),
        session_(session),
        files_(std::move(files)),
        reported_(std::move(reported)),
        only_(files_.size()) {}

  /// Opens the publishers. Returns an error with the reason if no topic can be played.
  Result<void> open();
  bool wait_for_subscribers();
  void play();
  void report();
  /// Reports what could not be read, except for the faults that were known when the files were opened.
  void report_faults();
  std::uint64_t published() const { return published_; }
  bool has_failed() const { return failed_; }

 private:
  void add_channel(std::size_t file, const recording::Channel& channel, RecordedTypes& types);
  Result<void> open_clock();
  std::string new_name(const std::string& topic) const;
  void find_first();
  void publish_retained(std::uint64_t from_ns);
  bool play_once(std::uint64_t from_ns);
  void publish(const PlayedFiles::Message& message);
  bool wait_until(Clock::time_point due, std::uint64_t time_ns);
  void pause();
  void publish_clock(std::uint64_t time_ns);
  std::uint64_t time_at(Clock::time_point now) const;

  const PlayOptions& options_;
  const CommonOptions& common_;
  Session& session_;
  PlayedFiles files_;
  const std::vector<ReportedFile> reported_;
  std::vector<std::set<std::uint16_t>> only_;        ///< the channels that are played, one set for each file
  std::map<std::string, PlayedChannel> channels_{};  ///< the channels by topic, type, QoS and node
  std::map<std::pair<std::size_t, std::uint16_t>, PlayedChannel*> of_channel_{};  ///< channels by file and id
  std::optional<DynamicPublisher> clock_{};
  std::set<std::string> missing_{};
  Keys keys_{};

  std::uint64_t first_ns_ = 0;  ///< the time of the first message
  std::uint64_t begin_ns_ = 0;  ///< the time in the recording that corresponds to begin_
  Clock::time_point begin_{};
  Clock::time_point next_clock_{};
  Clock::duration behind_{};     ///< the sum of the delays that were not caught up
  Clock::duration played_{};     ///< the time for which messages were played, without pauses
  std::uint64_t played_ns_ = 0;  ///< the time that was played, in the recording
  std::uint64_t published_ = 0;
  bool failed_ = false;
};

std::string plain(const std::string& topic) { return Session::plain_name(topic); }

std::string Player::new_name(const std::string& topic) const {
  for (const std::string& rule : options_.remap) {
    const std::size_t at = rule.find(":=");
    if (at != rule.npos && plain(rule.substr(0, at)) == topic) return plain(rule.substr(at + 2));
  }
  return topic;
}

void Player::add_channel(std::size_t file, const recording::Channel& channel, RecordedTypes& types) {
  const std::string topic = plain(channel.topic);
  const bool is_wanted =
      options_.topics.empty() ||
      std::ranges::any_of(options_.topics, [&](const auto& one) { return plain(one) == topic; });
  if (!is_wanted) return;
  const auto left_out = [&](const std::string& why) {
    const std::string sentence = fmt::format("topic '{}' is left out: {}", topic, why);
    if (missing_.insert(sentence).second) complain(printable(sentence));
  };
  const auto& schemas = files_.file(file).schemas();
  const auto schema = schemas.find(channel.schema);
  if (channel.encoding != "cdr")
    left_out("its messages are in '" + channel.encoding + "' and not in cdr");
  else if (schema == schemas.end())
    left_out("the recording does not say which type it has");
  if (channel.encoding != "cdr" || schema == schemas.end()) return;
  const Result<DynamicType>& type = types.find(schema->second, file);
  if (!type) return left_out(type.error().message);
  const std::string profiles = recording::value_of(channel.metadata, "offered_qos_profiles");
  const std::string key = fmt::format("{}\n{:x}\n{}\n{}", topic, type->hash(), profiles,
                                      recording::value_of(channel.metadata, "sft_node"));
  auto known = channels_.find(key);
  if (known == channels_.end()) {
    const Qos qos = recording::from_profiles(profiles);
    const bool is_retained = qos.durability == transient_local;
    const PublisherOptions offer{.reliability = qos.reliability,
                                 .durability = qos.durability,
                                 .history_depth = is_retained ? qos.history_depth : 1,
                                 .max_blocking = qos.reliability == reliable ? blocking_most : 0s};
    Result<DynamicPublisher> publisher = session_.node().publisher("/" + new_name(topic), *type, offer);
    if (!publisher) return left_out(publisher.error().message);
    known = channels_
                .emplace(key, PlayedChannel{new_name(topic), *std::move(publisher),
                                            is_retained ? qos.history_depth : 0})
                .first;
  }
  of_channel_[{file, channel.id}] = &known->second;
  only_[file].insert(channel.id);
}

Result<void> Player::open_clock() {
  constexpr const char* definition =
      "builtin_interfaces/Time clock\n===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
  const Result<DynamicType> type = from_msg("rosgraph_msgs/Clock", definition);
  if (!type) return tl::unexpected(type.error());
  return session_.node().publisher("/clock", *type).map([this](DynamicPublisher&& publisher) {
    clock_.emplace(std::move(publisher));
  });
}

void Player::find_first() {
  for (std::size_t i = 0; i < files_.size(); ++i) {
    // A file without a summary is read as a whole, which the user can stop.
    files_.file(i).set_is_stopped([this] { return session_.stop().wait_for(0ns); });
    const recording::Overview& overview = files_.file(i).overview();
    files_.file(i).set_is_stopped(nullptr);  // the thread of start() uses the file from here on
    if (overview.messages == 0) continue;
    first_ns_ = first_ns_ == 0 ? overview.first_ns : std::min(first_ns_, overview.first_ns);
  }
}

Result<void> Player::open() {
  for (const std::string& rule : options_.remap) {
    if (rule.find(":=") == rule.npos || rule.starts_with(":=") || rule.ends_with(":="))
      return fail(Errc::invalid_argument, "'" + rule + "' is no rule: write OLD:=NEW");
  }
  find_first();
  RecordedTypes types(common_);
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const auto& of_channel = files_.file(i).overview().of_channel;
    for (const auto& [id, channel] : files_.file(i).channels()) {
      if (session_.stop().wait_for(0ns)) return fail(Errc::unavailable, "playing was interrupted");
      if (of_channel.empty() || of_channel.contains(id)) add_channel(i, channel, types);
    }
  }
  for (const std::string& topic : options_.topics) {
    const bool is_there = std::ranges::any_of(
        channels_, [&](const auto& one) { return one.second.topic == new_name(plain(topic)); });
    if (!is_there)
      complain(printable(fmt::format("The recording has no topic '{}' that can be played.", plain(topic))));
  }
  if (channels_.empty()) return fail(Errc::unavailable, "the recording has nothing that can be played");
  return options_.clock_hz > 0 ? open_clock() : Result<void>();
}

bool Player::wait_for_subscribers() {
  if (!options_.wait_for) return true;
  const auto end = Clock::now() + seconds(common_.timeout_s);
  for (const auto& [key, channel] : channels_) {
    while (!channel.publisher.wait_for_subscribers(*options_.wait_for, 20ms)) {
      if (session_.stop().wait_for(0ns)) return false;
      if (Clock::now() < end) continue;
      std::string text =
          fmt::format("Nothing was played: {} of '{}' did not come within {:g} s",
                      count_text(*options_.wait_for, "subscriber"), channel.topic, common_.timeout_s);
      for (const PublisherStatus::Reader& reader : channel.publisher.status().readers) {
        if (!reader.served) text += fmt::format("; node '{}' is not served: {}", reader.node, reader.reason);
      }
      complain(printable(text + '.'));
      return false;
    }
  }
  for (const auto& [key, channel] : channels_) await_dds_readers(channel.publisher, session_.stop());
  return true;
}

void Player::publish(const PlayedFiles::Message& message) {
  PlayedChannel& channel = *of_channel_.at({message.file, message.message.channel});
  if (channel.retained > 0) {
    const std::string_view contents(reinterpret_cast<const char*>(message.data.data()), message.data.size());
    const std::tuple sample(message.message.publish_ns, message.message.sequence,
                            std::hash<std::string_view>()(contents));
    if (std::ranges::find(channel.published, sample) != channel.published.end()) return;
    channel.published.push_back(sample);
    if (channel.published.size() > channel.retained) channel.published.pop_front();
  }
  const Result<PublishStatus> done = channel.publisher.publish_cdr(message.data);
  if (!done) {
    const std::string sentence =
        fmt::format("topic '{}': a message is left out: {}", channel.topic, done.error().message);
    if (missing_.insert(sentence).second) complain(printable(sentence));
    failed_ = true;
    return;
  }
  ++channel.samples;
  ++published_;
}

/// Publishes the samples that publishers retained at the time at which playing starts.
void Player::publish_retained(std::uint64_t from_ns) {
  std::vector<std::set<std::uint16_t>> retained(files_.size());
  for (const auto& [at, channel] : of_channel_) {
    channel->published.clear();
    if (channel->retained > 0) retained[at.first].insert(at.second);
  }
  if (from_ns <= first_ns_ || std::ranges::all_of(retained, &std::set<std::uint16_t>::empty)) return;
  std::map<PlayedChannel*, std::deque<PlayedFiles::Message>> last;
  files_.for_each_before(from_ns, retained, [&](PlayedFiles::Message&& message) {
    PlayedChannel* const channel = of_channel_.at({message.file, message.message.channel});
    auto& kept = last[channel];
    kept.push_back(std::move(message));
    if (kept.size() > channel->retained) kept.pop_front();
  });
  for (const auto& [channel, messages] : last) {
    for (const PlayedFiles::Message& message : messages) publish(message);
  }
}

std::uint64_t Player::time_at(Clock::time_point now) const {
  const double passed = std::chrono::duration<double, std::nano>(now - begin_).count() * options_.rate;
  return begin_ns_ + static_cast<std::uint64_t>(std::max(passed, 0.0));
}

void Player::publish_clock(std::uint64_t time_ns) {
  constexpr std::uint64_t second = 1'000'000'000;
  struct {
    std::array<std::uint8_t, 4> encapsulation{0, 1, 0, 0};
    std::int32_t sec;
    std::uint32_t nanosec;
  } message{.sec = static_cast<std::int32_t>(time_ns / second),
            .nanosec = static_cast<std::uint32_t>(time_ns % second)};
  static_assert(sizeof message == 12);
  (void)clock_->publish_cdr(std::as_bytes(std::span(&message, 1)));
}

void Player::pause() {
  const auto paused_at = Clock::now();
  complain("Paused; the space bar goes on.");
  while (!session_.stop().wait_for(std::chrono::hours(1), keys_.descriptor()) && !keys_.pressed(' ')) {
  }
  const auto pause = Clock::now() - paused_at;
  begin_ += pause;
  next_clock_ += pause;
}

/// Waits until the time `due`, and publishes the clock meanwhile. Returns false if the user stops the
/// command.
bool Player::wait_until(Clock::time_point due, std::uint64_t time_ns) {
  Stop& stop = session_.stop();
  for (;;) {
    const auto now = Clock::now();
    if (clock_ && now >= next_clock_) {
      publish_clock(std::min(time_at(now), time_ns));
      next_clock_ = std::max(next_clock_, now - late_most) + seconds(1 / options_.clock_hz);
    }
    if (now >= due) return !stop.wait_for(0ns);
    const auto until = clock_ ? std::min(due, next_clock_) : due;
    if (stop.wait_for(until - now, keys_.descriptor())) return false;
    if (keys_.descriptor() < 0 || !keys_.pressed(' ')) continue;
    const auto before = begin_;
    pause();
    due += begin_ - before;
  }
}

/// Plays the recording once. Returns false if the user stops the command.
bool Player::play_once(std::uint64_t from_ns) {
  publish_retained(from_ns);
  files_.start(from_ns, only_);
  const std::uint64_t end_ns =
      options_.for_s > 0 ? from_ns + static_cast<std::uint64_t>(options_.for_s * ns_of_s) : UINT64_MAX;
  begin_ns_ = from_ns;
  begin_ = next_clock_ = Clock::now();
  std::uint64_t reached_ns = from_ns;
  bool goes_on = true;
  while (const std::optional<PlayedFiles::Message> message = files_.next()) {
    const std::uint64_t time_ns = message->message.log_ns;
    if (time_ns > end_ns) break;
    const auto offset = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::nano>(
        std::min(static_cast<double>(time_ns - from_ns) / options_.rate, most_ns)));
    goes_on = wait_until(begin_ + offset, time_ns);
    if (!goes_on) break;
    const auto late = Clock::now() - (begin_ + offset);
    if (late > late_most) {
      begin_ += late;
      const bool was_behind = behind_ > behind_max;
      behind_ += late;
      if (!was_behind && behind_ > behind_max) complain("It cannot keep up: all topics slow down.");
    }
    publish(*message);
    reached_ns = time_ns;
  }
  played_ += Clock::now() - begin_;
  played_ns_ += reached_ns - from_ns;
  files_.stop();
  return goes_on;
}

void Player::play() {
  const std::uint64_t from_ns = first_ns_ + static_cast<std::uint64_t>(options_.start_s * ns_of_s);
  for (bool goes_on = true; goes_on;) {
    const std::uint64_t before_ns = played_ns_;
    goes_on = play_once(from_ns) && options_.loop && published_ > 0;
    // Without a pause, a recording whose messages all have one time would be published as fast as the
    // processor allows.
    if (goes_on && played_ns_ == before_ns) goes_on = !session_.stop().wait_for(last_pause);
  }
  session_.stop().wait_for(last_pause);
}

void Player::report_faults() {
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const std::vector<std::string>& faults = files_.file(i).faults();
    for (std::size_t fault = reported_[i].faults; fault < faults.size(); ++fault) {
      complain(printable(reported_[i].path + ": " + faults[fault]));
      failed_ = true;
    }
  }
}

void Player::report() {
  Output& output = session_.output();
  const double behind_s = std::chrono::duration<double>(behind_).count();
  const double real_s = std::chrono::duration<double>(played_).count() + behind_s;
  const double reached = real_s > 0 ? static_cast<double>(played_ns_) / ns_of_s / real_s : 0;
  if (behind_s > 0 && reached < enough_of_rate * options_.rate)
    complain(fmt::format(
        "It was late by {:.2f} s in all, and played at {:.2f} times the recorded speed instead of {:g}.",
        behind_s, reached, options_.rate));
  nlohmann::ordered_json topics = nlohmann::ordered_json::object();
  for (const auto& [key, channel] : channels_) {
    topics[channel.topic] = topics.value(channel.topic, std::uint64_t{0}) + channel.samples;
    if (!common_.json)
      output.line(printable(fmt::format("{}: {} of {}", channel.topic, count_text(channel.samples, "sample"),
                                        ros_name(channel.publisher.type().name()))));
    for (const PublisherStatus::Reader& reader : channel.publisher.status().readers) {
      if (!reader.served && reader.incompatible_type)
        complain(printable(fmt::format("Node '{}' was sent nothing of '{}': {}.", reader.node, channel.topic,
                                       reader.reason)));
    }
  }
  if (common_.json)
    output.record({{"published", published_},
                   {"rate", reached},
                   {"behind_s", behind_s},
                   {"topics", std::move(topics)}});
}

}  // namespace

ExitCode run(const PlayOptions& options, const CommonOptions& common, Session& session) {
  std::vector<std::unique_ptr<recording::Recording>> files;
  std::vector<ReportedFile> reported;
  for (const std::string& given : options.files) {
    const Result<std::vector<std::string>> paths = recording::files_of(given);
    if (!paths) return give_up(paths.error());
    for (const std::string& path : *paths) {
      Result<std::unique_ptr<recording::Recording>> file = recording::open_recording(path);
      if (!file) return give_up(file.error());
      for (const std::string& fault : (*file)->faults()) complain(printable(path + ": " + fault));
      reported.push_back({path, (*file)->faults().size()});
      files.push_back(*std::move(file));
    }
  }
  Player player(options, common, session, std::move(files), std::move(reported));
  if (const Result<void> opened = player.open(); !opened) return give_up(opened.error());
  (void)session.look_around();  // existing subscribers are connected by the end of this call
  if (!player.wait_for_subscribers()) return ExitCode::nothing;
  player.play();
  player.report();
  player.report_faults();
  if (player.has_failed()) return ExitCode::failed;
  return player.published() > 0 ? ExitCode::done : ExitCode::nothing;
}

}  // namespace sft::tool
