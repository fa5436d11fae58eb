#include "tools/sft/record.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <malloc.h>
#include <sys/epoll.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <list>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "tools/recording/sample_type.h"
#include "tools/sft/definitions.h"
#include "tools/sft/describe.h"
#include "tools/sft/recorded_topic.h"
#include "tools/sft/topic_selection.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using Clock = std::chrono::steady_clock;
using RecordJson = nlohmann::ordered_json;
using namespace std::chrono_literals;

constexpr auto look_period = 50ms;  // the pause between two searches for new publishers
constexpr auto report_period = 1s;
constexpr auto missing_after = 5s;  // a topic without a publisher after this time is reported
constexpr double bytes_per_mb = 1e6;

/// Records the topics that the user names. Subscribes to a topic when a publisher of it appears.
class Recorder {
 public:
  Recorder(const RecordOptions& options, const CommonOptions& common, Session& session,
           std::vector<TopicSelection> wanted, std::vector<TopicSelection> triggers, SampleWriter& writer)
      : options_(options),
        common_(common),
        session_(session),
        wanted_(std::move(wanted)),
        triggers_(std::move(triggers)),
        writer_(writer),
        epoll_(epoll_create1(EPOLL_CLOEXEC)) {}
  ~Recorder() { close(epoll_); }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Records until the user stops the command, or until nothing more can be written.
  void run();
  const std::list<RecordedTopic>& topics() const { return topics_; }
  bool has_failed() const { return failed_; }
  RecordedTopic::Counts counts() const;
  void look_at_losses() {
    for (RecordedTopic& topic : topics_) topic.look_at_losses(writer_);
  }

 private:
  void look_for_publishers();
  void add(const DomainSnapshot::Endpoint& publisher, const std::string& text);
  void add_triggers(const RecordedTopic& topic);
  void take_samples();
  void report();
  void report_missing();
  void complain_once(const std::string& sentence) {
    if (complaints_.insert(sentence).second) complain(printable(sentence));
  }

  const RecordOptions& options_;
  const CommonOptions& common_;
  Session& session_;
  const std::vector<TopicSelection> wanted_;
  const std::vector<TopicSelection> triggers_;
  SampleWriter& writer_;
  const int epoll_;
  std::list<RecordedTopic> topics_{};
  std::list<DynamicSubscriber> open_triggers_{};
  std::set<std::string> working_triggers_{};  ///< the texts of the conditions that apply to some topic
  std::set<std::string> complaints_{};
  using TopicAndType = std::pair<std::string, std::string>;
  std::map<TopicAndType, DynamicType> types_{};  ///< the types that were found
  std::set<TopicAndType> refused_{};
  std::uint64_t reported_bytes_ = 0;
  const Clock::time_point begin_ = Clock::now();
  bool failed_ = false;
};

RecordedTopic::Counts Recorder::counts() const {
  RecordedTopic::Counts sum;
  for (const RecordedTopic& topic : topics_) {
    const RecordedTopic::Counts one = topic.counts();
    sum.samples += one.samples;
    sum.bytes += one.bytes;
    sum.lost_by_network += one.lost_by_network;
    sum.lost_by_queue += one.lost_by_queue;
    sum.lost_by_disk += one.lost_by_disk;
  }
  return sum;
}

void Recorder::look_for_publishers() {
  const DomainSnapshot domain = session_.domain();
  for (const DomainSnapshot::Endpoint& publisher : domain.publishers) {
    const std::string name = Session::plain_name(publisher.topic);
    const auto wanted = std::ranges::find(wanted_, name, &TopicSelection::topic);
    if (wanted != wanted_.end())
      add(publisher, wanted->text);
    else if (options_.all)
      add(publisher, "");
  }
}

void Recorder::add(const DomainSnapshot::Endpoint& publisher, const std::string& text) {
  const std::string name = Session::plain_name(publisher.topic);
  const std::pair key(name, publisher.type_name + "\n" + type_hash_text(publisher));
  if (refused_.contains(key)) return;
  const auto refuse = [&](const std::string& why) {
    refused_.insert(key);
    complain_once(why);
  };
  const auto known = types_.find(key);
  const Result<DynamicType> type = known != types_.end() ? Result<DynamicType>(known->second)
                                   : publisher.type      ? Result<DynamicType>(*publisher.type)
                                                         : definition_of(publisher, common_);
  if (!type) return refuse(fmt::format("topic '{}' is not recorded: {}", name, type.error().message));
  types_.emplace(key, *type);
  auto topic = std::ranges::find_if(topics_, [&](const RecordedTopic& one) {
    return one.topic() == name && one.type().hash() == type->hash() && one.type().name() == type->name();
  });
  if (topic == topics_.end()) {
    Result<RecordedTopic> opened = RecordedTopic::open(name, *type, text);
    if (!opened) {
      // A wrong selection ends the command, unless it is already recording other topics.
      failed_ |= opened.error().code != Errc::unavailable && topics_.empty();
      return refuse("not recorded: " + opened.error().message);
    }
    topics_.push_back(*std::move(opened));
    topic = std::prev(topics_.end());
    add_triggers(*topic);
  }
  const Result<void> followed = topic->follow(publisher, session_.node(), epoll_, writer_);
  if (!followed) refuse(fmt::format("topic '{}' is not recorded: {}", name, followed.error().message));
}

void Recorder::add_triggers(const RecordedTopic& topic) {
  for (const TopicSelection& trigger : triggers_) {
    if (!trigger.topic.empty() && trigger.topic != topic.topic()) continue;
    const bool fits = topic.type().support().parse_selection(trigger.text).has_value();
    if (!fits) continue;
    Result<DynamicSubscriber> subscriber =
        session_.node().subscriber("/" + topic.topic(), topic.type(), trigger.text, {.pollable = true});
    if (!subscriber) {
      complain_once(subscriber.error().message);
      continue;
    }
    working_triggers_.insert(trigger.text);
    open_triggers_.push_back(*std::move(subscriber));
    epoll_event event{.events = EPOLLIN, .data = {.ptr = nullptr}};
    epoll_ctl(epoll_, EPOLL_CTL_ADD, open_triggers_.back().file_descriptor(), &event);
  }
}

void Recorder::take_samples() {
  std::optional<std::uint64_t> now_ns;
  if (common_.sim_time) {
    now_ns = static_cast<std::uint64_t>(session_.node().now().time_since_epoch().count());
    if (*now_ns == 0) {  // without a time of the clock, samples cannot be stamped
      for (RecordedTopic& topic : topics_) topic.discard();
      (void)session_.stop().wait_for(
          look_period);  // retained samples stay queued, so a wait for samples would end at once
      return;
    }
  }
  std::array<epoll_event, 64> events{};
  const int ready = epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), 0);
  for (int i = 0; i < ready; ++i) {
    void* const topic = events[static_cast<std::size_t>(i)].data.ptr;
    if (topic != nullptr) static_cast<RecordedTopic*>(topic)->take(writer_, now_ns);
  }
  std::uint64_t triggered_ns = 0;
  for (DynamicSubscriber& trigger : open_triggers_) {
    while (const DynamicSample sample = trigger.take()) {
      const auto received = sample.info().receive_stamp.time_since_epoch().count();
      triggered_ns = std::max(triggered_ns, now_ns.value_or(static_cast<std::uint64_t>(received)));
    }
  }
  if (triggered_ns != 0) writer_.trigger(triggered_ns);
}

void Recorder::report_missing() {
  if (Clock::now() - begin_ < missing_after) return;
  for (const TopicSelection& wanted : wanted_) {
    const bool is_there = std::ranges::find(topics_, wanted.topic, &RecordedTopic::topic) != topics_.end();
    if (!is_there) complain_once(fmt::format("topic '{}' has no publisher yet", wanted.topic));
  }
  for (const TopicSelection& trigger : triggers_) {
    if (!working_triggers_.contains(trigger.text))
      complain_once(fmt::format("no topic has the fields of the condition '{}' yet", trigger.text));
  }
}

std::string losses_text(const RecordedTopic::Counts& counts) {
  return fmt::format("{} by the network, {} by queues, {} by the disk", counts.lost_by_network,
                     counts.lost_by_queue, counts.lost_by_disk);
}

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

void Recorder::report() {
  recording::Texts losses;
  for (const RecordedTopic& topic : topics_) {
    const RecordedTopic::Counts counts = topic.counts();
    if (counts.lost() > 0) losses["/" + topic.topic()] = losses_text(counts);
  }
  writer_.set_losses(std::move(losses));
  report_missing();
  const RecordedTopic::Counts all = counts();
  const SampleWriter::Status status = writer_.status();
  struct statvfs disk {};
  const bool is_known = statvfs(folder_of(options_.output).c_str(), &disk) == 0;
  const double left = is_known ? static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize) : 0;
  const double rate =
      static_cast<double>(all.bytes - reported_bytes_) / std::chrono::duration<double>(report_period).count();
  reported_bytes_ = all.bytes;
  const double time_s = std::chrono::duration<double>(Clock::now() - begin_).count();
  if (common_.json) {
    RecordJson topics = RecordJson::object();
    for (const RecordedTopic& topic : topics_) {
      const RecordedTopic::Counts one = topic.counts();
      topics[topic.topic()] = {{"samples", one.samples}, {"bytes", one.bytes}, {"lost", one.lost()}};
    }
    session_.output().record({{"time_s", time_s},
                              {"samples", all.samples},
                              {"bytes_per_s", rate},
                              {"file_bytes", status.bytes},
                              {"disk_left_bytes", left},
                              {"lost", all.lost()},
                              {"topics", std::move(topics)}});
  } else if (session_.output().on_terminal()) {
    session_.output().write(
        fmt::format("\r{:.0f} s, {}, {}, {}/s, {} on the disk, {} left, {} lost\x1b[K", time_s,
                    count_text(topics_.size(), "topic"), count_text(all.samples, "sample"), bytes_text(rate),
                    bytes_text(static_cast<double>(status.bytes)), bytes_text(left), all.lost()));
  }
}

void Recorder::run() {
  Stop& stop = session_.stop();
  auto next_look = begin_;
  auto next_report = begin_ + report_period;
  while (!stop.requested() && !failed_) {
    const auto now = Clock::now();
    if (options_.for_s > 0 && now - begin_ >= seconds(options_.for_s)) break;
    if (now >= next_look) {
      if (!writer_.status().fault.empty()) break;
      look_for_publishers();
      look_at_losses();
      next_look = now + look_period;
    }
    if (now >= next_report) {
      report();
      next_report = now + report_period;
    }
    stop.wait_for(look_period, epoll_);
    take_samples();
  }
  take_samples();  // takes the samples that have arrived by now
  look_at_losses();
  report();
  if (session_.output().on_terminal() && !common_.json) session_.output().write("\n");
}

std::string default_output() {
  return fmt::format("{:%Y-%m-%d-%H-%M-%S}.mcap",
                     std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now()));
}

/// Waits until all samples are written. If the user presses Ctrl-C again, ends the process.
void wait_for_end(SampleWriter& writer, Stop& stop) {
  stop.forget();
  writer.finish();
  for (int rounds = 0; !writer.status().is_over; ++rounds) {
    if (rounds == 20) complain("Writing what has come; press Ctrl-C again to give it up.");
    if (!stop.wait_for(50ms)) continue;
    complain("What was not written yet is lost.");
    _exit(static_cast<int>(ExitCode::failed));
  }
}

void print_summary(const Recorder& recorder, const SampleWriter::Status& status, bool json, Output& output) {
  const RecordedTopic::Counts all = recorder.counts();
  if (json) {
    RecordJson topics = RecordJson::object();
    for (const RecordedTopic& topic : recorder.topics()) {
      const RecordedTopic::Counts one = topic.counts();
      topics[topic.topic()] = {{"samples", one.samples},
                               {"bytes", one.bytes},
                               {"lost_by_network", one.lost_by_network},
                               {"lost_by_queue", one.lost_by_queue},
                               {"lost_by_disk", one.lost_by_disk}};
    }
    return output.record({{"files", status.files},
                          {"written", status.samples},
                          {"file_bytes", status.bytes},
                          {"lost", all.lost()},
                          {"fault", status.fault},
                          {"topics", std::move(topics)}});
  }
  for (const RecordedTopic& topic : recorder.topics()) {
    const RecordedTopic::Counts one = topic.counts();
    output.line(printable(fmt::format("{}: {}, {}{}", topic.topic(), count_text(one.samples, "sample"),
                                      bytes_text(static_cast<double>(one.bytes)),
                                      one.lost() == 0 ? "" : "; lost: " + losses_text(one))));
  }
  for (const std::string& file : status.files) output.line(printable("written: " + file));
  output.line(fmt::format("{} written, {}, {} lost", count_text(status.samples, "sample"),
                          bytes_text(static_cast<double>(status.bytes)), all.lost()));
}

Result<std::vector<TopicSelection>> parse_all(const std::vector<std::string>& texts) {
  std::vector<TopicSelection> parsed;
  for (const std::string& text : texts) {
    Result<TopicSelection> one = parse_topic_selection(text);
    if (!one) return tl::unexpected(one.error());
    if (std::ranges::find(parsed, one->topic, &TopicSelection::topic) != parsed.end())
      return fail(Errc::invalid_argument, "topic '" + one->topic + "' is named twice");
    parsed.push_back(*std::move(one));
  }
  return parsed;
}

/// Parses conditions with a topic, TOPIC@CONDITION, or without.
Result<std::vector<TopicSelection>> parse_triggers(const std::vector<std::string>& texts) {
  std::vector<TopicSelection> parsed;
  for (const std::string& text : texts) {
    Result<TopicSelection> one = TopicSelection{.topic = "", .text = " @ " + text};
    if (text.find('@') != text.npos) one = parse_topic_selection(text);
    if (!one) return tl::unexpected(one.error());
    parsed.push_back(*std::move(one));
  }
  return parsed;
}

ExitCode refuse(std::string_view sentence) {
  complain(sentence);
  return ExitCode::failed;
}

SampleWriter::Options options_of_writer(const RecordOptions& options, bool sim_time) {
  constexpr double ns = 1e9;
  SampleWriter::Options writer{.path = options.output};
  writer.file.compression = options.compression == "zstd"  ? recording::Compression::zstd
                            : options.compression == "lz4" ? recording::Compression::lz4
                                                           : recording::Compression::none;
  writer.file.library = "sft " + options.version;
  writer.memory_bytes = static_cast<std::uint64_t>(options.memory_mb * bytes_per_mb);
  writer.split_bytes = static_cast<std::uint64_t>(options.split_mb * bytes_per_mb);
  writer.split_time = std::chrono::nanoseconds(static_cast<std::int64_t>(options.split_s * ns));
  writer.window = std::chrono::nanoseconds(static_cast<std::int64_t>(options.last_s * ns));
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  writer.about = {{"clock", sim_time ? "/clock" : "system"}, {"host", host.data()}};
  return writer;
}

}  // namespace

ExitCode run(const RecordOptions& given, const CommonOptions& common, Session& session) {
  RecordOptions options = given;
  if (options.output.empty()) options.output = default_output();
  const Result<std::vector<TopicSelection>> wanted = parse_all(options.topics);
  if (!wanted) return refuse(wanted.error().message);
  const Result<std::vector<TopicSelection>> triggers = parse_triggers(options.on);
  if (!triggers) return refuse(triggers.error().message);
  if (wanted->empty() && !options.all) return refuse("Name topics, or --all.");
  if ((options.last_s > 0) != !triggers->empty()) return refuse("--last and --on belong together.");
  const SampleWriter::Options writer_options = options_of_writer(options, common.sim_time);
  const std::string first_file = SampleWriter::path_of(writer_options, 0);
  std::error_code ignored;
  if (std::filesystem::exists(first_file, ignored))
    return refuse(printable(fmt::format("'{}' is there already; name another file.", first_file)));
  // If only a window is recorded, the first file is created at the first trigger.
  if (access(folder_of(first_file).c_str(), W_OK) != 0) {
    return refuse(printable(
        fmt::format("'{}' cannot be made: {}.", first_file, std::generic_category().message(errno))));
  }
  // Keeps freed memory in the process, because the next samples need it again.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);

  SampleWriter writer(writer_options);
  Recorder recorder(options, common, session, *wanted, *triggers, writer);
  recorder.run();
  wait_for_end(writer, session.stop());
  recorder.look_at_losses();  // the losses on the disk are known only now
  const SampleWriter::Status status = writer.status();
  print_summary(recorder, status, common.json, session.output());
  if (!status.fault.empty()) return refuse(printable(status.fault + "."));
  if (recorder.has_failed()) return ExitCode::failed;
  return recorder.counts().samples > 0 ? ExitCode::done : ExitCode::nothing;
}

}  // namespace sft::tool
