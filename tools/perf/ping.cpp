#include "tools/perf/ping.h"

#include <fmt/format.h>
#include <sys/prctl.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <thread>
#include <tuple>
#include <utility>

#include "tools/perf/floor.h"
#include "tools/perf/protocol.h"
#include "tools/perf/sequence.h"
#include "tools/terminal/file_error.h"
#include "tools/terminal/units.h"

namespace sft::perf {

using namespace std::chrono_literals;

namespace {

// Not in the results: caches are cold, and paths are not chosen yet
constexpr std::uint64_t first_samples = 10;
// The lanes are measured in turns of this length, so that a disturbance affects all of them
constexpr double slice_s = 1;
// The time for which sending without pauses waits for slow readers
constexpr std::chrono::nanoseconds flow_control = 500ms;
// The time for which the last answers of a slice are awaited
constexpr std::int64_t grace_ns = 1'000'000'000;

/// An answer, with its time of arrival by the clocks of this host. `stamp_ns` is its time of publishing by
/// the clock of the other host; 0: not known.
struct Answer {
  std::uint64_t from = 0;
  std::uint64_t number = 0;
  std::int64_t came_ns = 0;
  std::int64_t came_time_ns = 0;
  std::int64_t stamp_ns = 0;
};

/// The answers to one lane (one of the ways of sending, result.h). Threads of the node or of a socket add
/// them.
class Inbox {
 public:
  void add(const Answer& answer) {
    const std::scoped_lock lock(mutex_);
    answers_.push_back(answer);
  }
  void reserve(std::size_t answers) {
    const std::scoped_lock lock(mutex_);
    answers_.reserve(answers);
  }
  std::size_t size() const {
    const std::scoped_lock lock(mutex_);
    return answers_.size();
  }
  std::vector<Answer> take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(answers_, {});
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Answer> answers_;
};

/// The state of one lane: the samples that were sent, and the answers.
struct Track {
  struct Sent {
    std::int64_t counted_ns = 0;  ///< the result of counted_from()
    std::int64_t sent_ns = 0;
    std::int64_t time_ns = 0;
  };
  Lane lane;
  Inbox inbox;
  std::vector<Sent> sent;                    ///< the samples by their numbers, from 1
  std::map<std::uint64_t, Tally> tallies;    ///< the samples that arrived, by side
  std::map<std::uint64_t, double> before_s;  ///< the latency of the previous answer, by side
  std::map<std::uint64_t, std::vector<Part>> parts;
  std::uint64_t number = 0;        ///< the number of the last sample that was sent
  std::uint64_t came = 0;          ///< the number of answers that were evaluated
  std::uint64_t warm = 0;          ///< the number of the last sample that is not in the figures
  std::uint64_t warm_arrived = 0;  ///< the number of samples that had arrived up to that sample
  std::optional<double> first_s;
  std::optional<Sender> sender;  ///< empty for plain sockets
  std::unique_ptr<FloorClient> socket;
  /// must be the last member, because its callbacks use the others
  std::optional<DynamicSubscriber> answers;

  bool send(std::uint64_t next) { return sender ? sender->send() : socket->send(next); }
};

/// Returns the host of "10.0.0.5:40123".
std::string host_of(const std::string& address) { return address.substr(0, address.rfind(':')); }

class Ping {
 public:
  Ping(Node node, DynamicType type, std::shared_ptr<const Payload> payload, const Plan& plan,
       tool::Stop& stop)
      : node_(std::move(node)),
        type_(std::move(type)),
        payload_(std::move(payload)),
        plan_(plan),
        stop_(stop) {}

  Result<Outcome> run(const Progress& progress) {
    prctl(PR_SET_TIMERSLACK, 1);  // makes waits exact to 1 ns instead of 50 us
    if (!plan_.raw_file.empty()) {
      raw_.open(plan_.raw_file);
      if (!raw_) return tl::unexpected(tool::cannot_be_written(plan_.raw_file));
      raw_ << "lane,sample,side,sent_ns,latency_ns\n";
    }
    if (Result<void> opened = open(); !opened) return tl::unexpected(opened.error());
    for (std::size_t i = 0; i < tracks_.size(); ++i)
      if (Result<void> met = warm_up(*tracks_[i]); !met) return tl::unexpected(met.error());
    for (const auto& [wanted, kind, name] :
         {std::tuple(plan_.beside_udp, Socket::udp, "udp"), std::tuple(plan_.beside_tcp, Socket::tcp, "tcp")})
      if (Result<void> met = wanted ? open_socket(kind, name) : Result<void>(); !met)
        return tl::unexpected(met.error());
    // The number of samples of each lane
    const double samples = std::max(1.0, std::round(plan_.for_s * plan_.rate_hz));
    double slices = std::max(1.0, std::round(plan_.for_s / slice_s));
    if (plan_.rate_hz > 0) slices = std::min(slices, samples);
    for (double done = 0; done < slices && goes_on(); ++done) {
      const double count = std::floor(samples * (done + 1) / slices) - std::floor(samples * done / slices);
      for (auto& track : tracks_)
        if (goes_on()) slice(*track, plan_.for_s / slices, static_cast<std::uint64_t>(count));
      progress(line());
    }
    return finish();
  }

 private:
  Result<void> open() {
    const Result<std::string> definition = to_msg(type_);
    if (!definition) return tl::unexpected(definition.error());
    std::vector<std::pair<std::string, std::string>> selections{{"sft", plan_.fields}};
    if (plan_.beside_whole) selections.emplace_back("whole", "*");
    offer_ = {.session = random_number(), .type = std::string(type_.name()), .definition = *definition};
    for (const auto& [name, fields] : selections) offer_.fields.push_back(fields);
    offer_.transport = plan_.transport;
    offer_.reliable = plan_.reliable;
    offer_.answers = plan_.answers;
    offer_.loans = plan_.loans;
    offer_.udp = plan_.beside_udp;
    offer_.tcp = plan_.beside_tcp;
    for (std::size_t i = 0; i < selections.size(); ++i) {
      Result<void> opened = open_stream(i, selections[i].first);
      if (!opened) return opened;
    }
    const auto keep = [](auto& to) { return [&to](auto&& opened) { to.emplace(std::move(opened)); }; };
    return node_.publisher(topic_of(offer_.session, "message"), type_, retained())
        .map(keep(message_))
        .and_then([&] { return message_->publish_cdr(*payload_); })
        .and_then([&](PublishStatus) {
          return node_.subscriber(topic_of(offer_.session, "reports"), text_type(), "*",
                                  {.reliability = reliable, .durability = transient_local, .depth = 64});
        })
        .map(keep(reports_))
        .and_then([&] { return node_.publisher(offer_topic, text_type(), retained()); })
        .map(keep(offers_))
        .and_then([&] { return publish_text(*offers_, text_of(offer_)); })
        .and_then([&] { return meet(); });
  }

  Result<void> open_stream(std::size_t number, const std::string& name) {
    Track& track = *tracks_.emplace_back(std::make_unique<Track>());
    track.lane.name = name;
    track.lane.fields = offer_.fields[number];
    const std::string suffix = std::to_string(number);
    Result<Sender> sender =
        Sender::open(node_, topic_of(offer_.session, "samples" + suffix), type_, payload_, plan_.loans,
                     {.transport = plan_.transport,
                      .reliability = plan_.reliable ? reliable : best_effort,
                      .max_blocking = plan_.reliable && plan_.rate_hz <= 0 ? flow_control : 0ns});
    if (!sender) return tl::unexpected(sender.error());
    track.sender.emplace(*std::move(sender));
    if (!plan_.answers)
      return type_.support().parse_selection(track.lane.fields).map([](const Selection&) {});
    return node_
        .subscriber(topic_of(offer_.session, "answers" + suffix), type_, track.lane.fields,
                    {.transport = plan_.transport,
                     .reliability = plan_.reliable ? reliable : best_effort,
                     .depth = 256},
                    [inbox = &track.inbox](const DynamicSample& sample) {
                      const std::int64_t came = now_ns();
                      const SampleInfo& info = sample.info();
                      inbox->add({info.writer, info.sequence, came, time_ns(),
                                  info.source_stamp.time_since_epoch().count()});
                    })
        .map([&](DynamicSubscriber&& answers) { track.answers.emplace(std::move(answers)); });
  }

  /// Waits until all sides have reported, and all streams are connected.
  Result<void> meet() {
    const std::int64_t end = now_ns() + std::llround(plan_.timeout_s * 1e9);
    while (!collect(0) || !are_connected()) {
      if (stop_.wait_for(5ms)) return fail(Errc::unavailable, "stopped before another side answered");
      for (const auto& [side, report] : sides_)
        if (!report.error.empty()) return fail(Errc::invalid_argument, "the other side: " + report.error);
      if (now_ns() < end) continue;
      return fail(
          Errc::unavailable,
          fmt::format(
              "{} of {} answered within {:g} s in domain {}: start 'sft perf {}' on the other machine, "
              "in the same domain; 'sft doctor' there and here finds what keeps them apart",
              sides_.size(), tool::count_text(plan_.sides, "side"), plan_.timeout_s, node_.status().domain,
              plan_.answers ? "pong" : "sub"));
    }
    run_.sides = sides_.size();
    agree();
    for (const std::int64_t met = now_ns(); !has_settled(met);)
      if (stop_.wait_for(5ms)) break;
    return {};
  }

  void agree() {
    const HostClock here = host_clock();
    for (const auto& [side, report] : sides_) {
      const Agreement agreed = agreement(here, report.clock);
      const bool worse = run_.clocks.empty() || !agreed.within_s ||
                         (run_.clocks_within_s && *agreed.within_s > *run_.clocks_within_s);
      if (worse) run_.clocks = agreed.words, run_.clocks_within_s = agreed.within_s;
    }
  }

  /// Returns true if the paths of the samples will not change any more. Within a host, the first path may
  /// be UDP, until the daemon of shared memory has started.
  bool has_settled(std::int64_t since_ns) const {
    constexpr std::int64_t start_of_daemon_ns = 2'000'000'000;
    const bool may_use_shm = run_.clocks_within_s == 0 && plan_.transport != TransportChoice::udp;
    if (!may_use_shm || now_ns() - since_ns > start_of_daemon_ns) return true;
    return std::ranges::all_of(
        tracks_[0]->sender->status().readers,
        [](const PublisherStatus::Reader& reader) { return reader.transport == TransportKind::shm; });
  }

  bool are_connected() const {
    return std::ranges::all_of(tracks_, [&](const auto& track) {
      const auto readers = track->sender->status().readers;
      const auto served = std::ranges::count_if(readers, &PublisherStatus::Reader::served);
      if (static_cast<std::size_t>(served) < sides_.size()) return false;
      if (!track->answers) return true;
      const auto writers = track->answers->status().writers;
      const auto connected = std::ranges::count_if(writers, &SubscriberStatus::Writer::connected);
      return static_cast<std::size_t>(connected) >= sides_.size();
    });
  }

  /// Takes reports. Returns true if all sides have answered this mark. During a run, only the sides with
  /// which it began are considered, since a side that reports later has missed samples.
  bool collect(std::uint64_t mark) {
    while (const auto text = take_text(*reports_)) {
      std::optional<Report> report = report_of(*text);
      if (!report || report->session != offer_.session) continue;
      if (run_.sides > 0 && !sides_.contains(report->side)) continue;
      for (std::size_t i = 0; i < report->streams.size() && i < offer_.fields.size(); ++i) {
        const Report::Stream& stream = report->streams[i];
        auto& parts = tracks_[i]->parts[stream.publisher];
        parts.insert(parts.end(), stream.parts.begin(), stream.parts.end());
      }
      sides_[report->side] = *std::move(report);
    }
    const auto answered =
        std::ranges::count_if(sides_, [&](const auto& side) { return side.second.mark == mark; });
    return static_cast<std::size_t>(answered) >= std::max<std::size_t>({plan_.sides, run_.sides, 1});
  }

  bool goes_on() const { return run_.error.empty() && !run_.interrupted && !stop_.requested(); }

  /// Returns true if the user does not want to wait for reports. The first Ctrl-C ends only the sending:
  /// without reports, samples would seem lost.
  bool is_hurried() {
    if (!stop_.wait_for(0ns)) return false;
    if (run_.interrupted) return true;
    run_.interrupted = true;
    stop_.forget();
    return false;
  }

  /// Requests a report from all sides. Returns false if one of them does not answer.
  bool mark(bool ends) {
    ++offer_.mark;
    offer_.ends = ends;
    if (!publish_text(*offers_, text_of(offer_))) return false;
    const std::int64_t end = now_ns() + 3 * grace_ns;
    while (!collect(offer_.mark)) {
      if (now_ns() > end || is_hurried()) return false;
      reports_->wait(50ms);
    }
    return true;
  }

  Usage far_usage() const {
    Usage sum;
    for (const auto& [side, report] : sides_) sum = sum + report.usage;
    return sum;
  }
  std::uint64_t far_received(const Track& track) const {
    std::uint64_t sum = 0;
    for (const auto& [side, report] : sides_) {
      for (std::size_t i = 0; i < report.streams.size(); ++i)
        if (i < tracks_.size() && tracks_[i].get() == &track) sum += report.streams[i].received;
      if (track.lane.name == "udp") sum += report.udp_received;
      if (track.lane.name == "tcp") sum += report.tcp_received;
    }
    return sum;
  }

  /// Returns the number of sides that receive each sample. A plain socket sends to only one of them.
  std::size_t readers(const Track& track) const { return track.socket ? 1 : sides_.size(); }

  /// Sends the first samples, which are not in the results. After that, the path and the size of a message
  /// are known.
  Result<void> warm_up(Track& track) {
    const std::uint64_t arrived_before = far_received(track);
    pace(track, first_samples, std::max(plan_.rate_hz, 20.0));
    settle(track, 0);
    if (!mark(false) || run_.interrupted)
      return fail(Errc::unavailable, "stopped, or the other side has stopped answering");
    evaluate(track);
    Lane lane{.name = track.lane.name, .fields = track.lane.fields, .path = track.lane.path};
    lane.message_bytes = track.lane.message_bytes;
    lane.first_s = track.first_s;
    track.lane = std::move(lane);
    track.tallies.clear();
    track.before_s.clear();
    track.warm = track.number;
    track.warm_arrived = far_received(track);
    if (track.socket && track.warm_arrived == arrived_before)
      return fail(Errc::unavailable,
                  track.lane.name + " beside SFT: nothing arrived; a firewall may forbid it");
    if (track.sender) describe(track);
    return {};
  }

  /// Notes the path of the samples of a stream, and their size on this path.
  void describe(Track& track) const {
    track.lane.message_bytes = static_cast<double>(payload_->size());
    for (const PublisherStatus::Reader& reader : track.sender->status().readers) {
      const std::string path = to_string(reader.transport);
      if (!reader.served) continue;
      if (track.lane.path.find(path) == std::string::npos)
        track.lane.path += (track.lane.path.empty() ? "" : "+") + path;
      if (reader.transport == TransportKind::udp && reader.sent > 0)
        track.lane.message_bytes = static_cast<double>(reader.bytes_sent) / static_cast<double>(reader.sent);
    }
  }

  /// Tries the addresses of the other hosts until the side with the port answers at one of them.
  Result<void> open_socket(Socket kind, const char* name) {
    const Report& report = sides_.begin()->second;
    const auto port = static_cast<std::uint16_t>(kind == Socket::udp ? report.udp_port : report.tcp_port);
    Result<void> result = fail(Errc::unavailable, "the other host has sent no address");
    for (const std::string& host : addresses()) {
      Track& track = *tracks_.emplace_back(std::make_unique<Track>());
      track.lane.name = track.lane.path = name;
      track.lane.message_bytes = tracks_[0]->lane.message_bytes;
      auto socket = FloorClient::open(kind, host, port, offer_.session,
                                      static_cast<std::size_t>(std::llround(track.lane.message_bytes)),
                                      [inbox = &track.inbox](std::uint64_t number) {
                                        inbox->add({1, number, now_ns(), 0, 0});
                                      });
      result = socket.map([](const auto&) {});
      if (socket) track.socket = *std::move(socket);
      if (socket) result = warm_up(track);
      if (result) return result;
      tracks_.pop_back();
    }
    return result;
  }

  std::vector<std::string> addresses() const {
    const auto served = tracks_[0]->sender->status().readers;
    std::vector<std::string> found;
    for (const DomainSnapshot::Endpoint& endpoint : node_.domain().subscribers) {
      if (std::ranges::find(served, endpoint.id, &PublisherStatus::Reader::id) == served.end()) continue;
      for (const std::string& address : endpoint.addresses) found.push_back(host_of(address));
    }
    if (run_.clocks_within_s == 0) found.emplace_back("127.0.0.1");
    return found;
  }

  /// Sends `count` samples, or samples for `for_s` seconds if no rate is set. Then waits for the answers
  /// and evaluates them.
  void slice(Track& track, double for_s, std::uint64_t count) {
    const Usage here = usage_now(), far = far_usage();
    const std::int64_t begin = now_ns();
    const std::uint64_t number = track.number, came = track.came;
    if (plan_.rate_hz > 0) {
      pace(track, count, plan_.rate_hz);
    } else {
      flood(track, begin + std::llround(for_s * 1e9));
    }
    track.lane.seconds += static_cast<double>(now_ns() - begin) * 1e-9;
    if (plan_.answers) settle(track, came + (track.number - number) * readers(track));
    if (!mark(false))
      run_.error = stop_.requested() ? "stopped before the other side has sent its report"
                                     : "the other side has stopped answering";
    if (!plan_.answers) drain(track);
    evaluate(track);
    track.lane.here = track.lane.here + (usage_now() - here);
    track.lane.far = track.lane.far + (far_usage() - far);
    flush_raw();
  }

  /// The reason is that of the first failure.
  void flush_raw() {
    if (raw_.is_open() && !raw_.flush() && run_.error.empty())
      run_.error = tool::cannot_be_written(plan_.raw_file).message;
  }

  /// Sends by a schedule that begins now.
  void pace(Track& track, std::uint64_t count, double rate_hz) {
    const auto period = static_cast<std::int64_t>(1e9 / rate_hz);
    track.inbox.reserve(count * readers(track));
    track.sent.reserve(track.sent.size() + count);
    const std::int64_t begin = now_ns();
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::int64_t due = begin + static_cast<std::int64_t>(i) * period;
      if (stop_.wait_for(std::chrono::nanoseconds(due - now_ns()))) return;
      send_one(track, due, period);
    }
    stop_.wait_for(std::chrono::nanoseconds(begin + static_cast<std::int64_t>(count) * period - now_ns()));
  }

  void flood(Track& track, std::int64_t end) {
    constexpr int at_once = 64;
    while (now_ns() < end && !stop_.wait_for(0ns))
      for (int i = 0; i < at_once && now_ns() < end; ++i)
        track.send(track.number + 1) ? ++track.number : ++track.lane.refused;
  }

  void send_one(Track& track, std::int64_t due, std::int64_t period) {
    const std::int64_t time = time_ns(), sent = now_ns();
    bool is_late = false;
    const std::int64_t counted = counted_from(due, sent, period, is_late);
    if (is_late) ++track.lane.late;
    // Noted before the sample is sent, because the answer may arrive before send() returns.
    if (plan_.answers) track.sent.push_back({counted, sent, time});
    if (track.send(track.number + 1)) {
      ++track.number;
      return;
    }
    ++track.lane.refused;
    if (plan_.answers) track.sent.pop_back();
  }

  /// Waits until this number of answers has arrived in total, or until it seems that no more will arrive.
  void settle(Track& track, std::size_t expected) const {
    constexpr std::int64_t least_ns = 50'000'000;
    const auto longest = static_cast<std::int64_t>(track.lane.latency.max().value_or(grace_ns));
    const std::int64_t quiet_ns = std::clamp(8 * longest, least_ns, grace_ns);
    const std::int64_t end = now_ns() + grace_ns;
    if (expected == 0) expected = track.number * readers(track);
    std::size_t came = track.came + track.inbox.size();
    for (std::int64_t changed = now_ns(); came < expected && now_ns() < std::min(end, changed + quiet_ns);) {
      std::this_thread::sleep_for(1ms);
      const std::size_t now = track.came + track.inbox.size();
      if (now != came) changed = now_ns();
      came = now;
    }
  }

  /// Waits until no more samples arrive at sides that only count them.
  void drain(const Track& track) {
    std::uint64_t before = 0;
    do {
      before = far_received(track);
      std::this_thread::sleep_for(10ms);
    } while (run_.error.empty() && mark(false) && far_received(track) != before);
  }

  /// Evaluates the answers that have arrived, as far as the last reports describe them.
  void evaluate(Track& track) {
    for (const Answer& answer : track.inbox.take()) {
      ++track.came;
      const std::uint64_t number =
          track.sender ? sample_of(answer.number, track.parts[answer.from]) : answer.number;
      if (number <= track.warm || number > track.sent.size()) continue;
      if (!track.tallies[answer.from].note(number)) continue;
      const Track::Sent& sent = track.sent[number - 1];
      const std::int64_t round_trip = answer.came_ns - sent.sent_ns;
      const std::int64_t latency = sent.sent_ns - sent.counted_ns + round_trip / 2;
      const double latency_s = static_cast<double>(latency) * 1e-9;
      if (number == 1) track.first_s = latency_s;
      track.lane.latency.add(latency);
      const auto [before, is_first] = track.before_s.try_emplace(answer.from, latency_s);
      if (!is_first) {
        track.lane.jitter_sum_s += std::abs(latency_s - before->second);
        ++track.lane.jitter_count;
      }
      before->second = latency_s;
      if (track.sender) note_one_way(track, sent, answer, round_trip);
      if (raw_.is_open() && track.warm > 0)
        raw_ << track.lane.name << ',' << number << ',' << answer.from << ',' << sent.sent_ns << ','
             << latency << '\n';
    }
    track.lane.sent = (track.number - track.warm) * readers(track);
    track.lane.arrived = far_received(track) - track.warm_arrived;
    track.lane.returned = track.lane.reordered = track.lane.twice = 0;
    for (const auto& [side, tally] : track.tallies) {
      track.lane.returned += tally.distinct();
      track.lane.reordered += tally.reordered();
      track.lane.twice += tally.twice();
    }
  }

  void note_one_way(Track& track, const Track::Sent& sent, const Answer& answer, std::int64_t round_trip) {
    const std::int64_t there = answer.stamp_ns - sent.time_ns;
    const std::int64_t back = answer.came_time_ns - answer.stamp_ns;
    track.lane.there.add(there);
    track.lane.back.add(back);
    run_.any_negative = run_.any_negative || there < 0 || back < 0;
    const double error_s = static_cast<double>(round_trip) * 0.5e-9;
    if (run_.offset_s && error_s >= run_.offset_error_s) return;
    run_.offset_s = static_cast<double>(there - back) * 0.5e-9;
    run_.offset_error_s = error_s;
  }

  std::string line() const {
    std::string text;
    for (const auto& track : tracks_) {
      const Values values = track->lane.values(plan_.answers);
      const auto time = [&](const char* name) {
        const auto value = values.at(name);
        return value ? tool::duration_text(*value) : std::string("-");
      };
      text += fmt::format("{}{}: ", text.empty() ? "" : "; ", track->lane.name);
      text += plan_.answers ? fmt::format("p50 {}, p99 {}", time("p50"), time("p99"))
                            : tool::rate_text(values.at("rate").value_or(0));
      text += fmt::format(", {} lost", values.at("lost").value_or(0));
    }
    return text;
  }

  Result<Outcome> finish() {
    (void)is_hurried();  // clears a request that came after the last slice
    if (run_.error.empty() && !mark(true)) run_.error = "the other side has not sent its last report";
    run_.answers = plan_.answers;
    run_.rate_hz = plan_.rate_hz;
    run_.type = type_.name();
    run_.reliability = plan_.reliable ? "reliable" : "best effort";
    if (plan_.loans) run_.reliability += ", loans";
    for (const auto& track : tracks_) {
      if (run_.error.empty()) evaluate(*track);
      const Lane& lane = track->lane;
      const auto sent = static_cast<double>(track->number - track->warm + lane.refused);
      const double rate = lane.seconds > 0 ? sent / lane.seconds : 0;
      if (rate < 0.95 * plan_.rate_hz && !run_.interrupted && run_.error.empty())
        run_.remarks.push_back(fmt::format("{}: this program was the limit: it sent {} of {}", lane.name,
                                           tool::rate_text(rate), tool::rate_text(plan_.rate_hz)));
      run_.lanes.push_back(lane);
    }
    constexpr double low_rate_hz = 200;
    const std::string settings = idle_settings();
    if (plan_.rate_hz > 0 && plan_.rate_hz < low_rate_hz && !settings.empty())
      run_.remarks.push_back("at this rate processors fall idle between samples: " + settings);
    flush_raw();
    return std::move(run_);
  }

  Node node_;
  DynamicType type_;
  std::shared_ptr<const Payload> payload_;
  const Plan& plan_;
  tool::Stop& stop_;
  Offer offer_;
  Outcome run_;
  std::ofstream raw_;
  std::map<std::uint64_t, Report> sides_;
  std::optional<DynamicPublisher> message_, offers_;
  std::optional<DynamicSubscriber> reports_;
  std::vector<std::unique_ptr<Track>> tracks_;
};

}  // namespace

Result<Outcome> measure(Node node, const DynamicType& type, std::shared_ptr<const Payload> payload,
                        const Plan& plan, tool::Stop& stop, const Progress& progress) {
  return Ping(std::move(node), type, std::move(payload), plan, stop).run(progress);
}

}  // namespace sft::perf
