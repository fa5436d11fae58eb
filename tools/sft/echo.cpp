#include "tools/sft/echo.h"

#include <fmt/format.h>

#include <chrono>
#include <cstddef>
#include <set>

#include "tools/sft/csv.h"

namespace sft::tool {

namespace {

constexpr std::size_t elements_on_terminal = 16;
constexpr std::size_t text_on_terminal = 400;
constexpr std::size_t bytes_most = std::size_t{1} << 30;

/// Prints samples of one topic and type in the chosen format.
class Printer {
 public:
  Printer(const EchoOptions& options, const FoundTopic& topic, const FieldMask& mask, Output& output)
      : format_(options.format),
        has_several_(options.fields.size() > 1),
        output_(output),
        table_(topic.type.support(), mask),
        topic_(topic.name) {
    yaml_ = {.elements_max = SIZE_MAX, .text_bytes_max = SIZE_MAX, .output_bytes_max = bytes_most};
    json_.output_bytes_max = bytes_most;
    if (!output.on_terminal() || options.full) return;
    yaml_.elements_max = json_.elements_max = elements_on_terminal;
    yaml_.text_bytes_max = text_on_terminal;
    json_.bytes_as_base64 = false;  // base64 cannot be shortened
  }

  Result<void> print(const DynamicSample& sample) {
    report_missing_channels(sample);
    const Result<std::string> text = text_of(sample);
    if (!text) return tl::unexpected(text.error());
    if (format_ == Format::csv && !has_header_) output_.line(table_.header());
    has_header_ = true;
    if (format_ == Format::yaml && has_several_)
      output_.line(fmt::format("# selection {}", sample.info().selection));
    output_.write(*text + (format_ == Format::yaml ? "---\n" : "\n"));
    return {};
  }

 private:
  /// Reports missing channels. Channels are described in the data and not in the type, so it only turns out
  /// when a sample arrives that a channel is missing.
  void report_missing_channels(const DynamicSample& sample) {
    for (const std::string& channel : sample.missing_channels()) {
      if (!missing_.insert(channel).second) continue;
      complain(fmt::format(
          "The cloud has no channel '{}'; 'sft echo {} --fields fields[].name --once' lists those it has.",
          channel, topic_));
    }
  }

  Result<std::string> text_of(const DynamicSample& sample) const {
    if (format_ == Format::json) return sample.to_json(json_);
    return format_ == Format::yaml ? sample.to_yaml(yaml_) : table_.row(sample.view(), json_);
  }

  Format format_;
  bool has_several_;  ///< true: there are samples of several selections
  Output& output_;
  CsvTable table_;
  YamlOptions yaml_;
  JsonOptions json_;
  bool has_header_ = false;
  std::string topic_;
  std::set<std::string> missing_;  ///< the missing channels that were reported
};

Result<DynamicSubscriber> subscribe(const EchoOptions& options, const FoundTopic& topic, Node& node) {
  SubscriberOptions subscriber{.durability = topic.requested.durability,
                               .depth = 64,
                               .max_rate_hz = options.max_rate_hz,
                               .pollable = true};
  // A sample in shared memory has every field. This setting reduces it to the fields that the user has
  // requested.
  subscriber.recording.as_remote = options.fields != std::vector<std::string>{"*"};
  subscriber.further_selections.assign(options.fields.begin() + 1, options.fields.end());
  return node.subscriber(topic.name, topic.type, options.fields.front(), subscriber);
}

/// Returns the fields that samples may have.
Result<FieldMask> all_fields(const EchoOptions& options, const TypeSupport& type) {
  FieldMask all(type.leaves());
  for (const std::string& text : options.fields) {
    const Result<Selection> selection = type.parse_selection(text);
    if (!selection) return tl::unexpected(selection.error());
    all |= type.closed(*selection).mask();
  }
  return all;
}

/// Prints samples as they arrive, and returns their number. If the user wants a certain number of samples,
/// the command waits no longer than the timeout for the first sample.
Result<std::uint64_t> print_samples(const EchoOptions& options, const CommonOptions& common,
                                    DynamicSubscriber& subscriber, Printer& printer, Stop& stop) {
  using Clock = std::chrono::steady_clock;
  const auto given_up_at = Clock::now() + seconds(common.timeout_s);
  std::uint64_t printed = 0;
  while (!stop.requested()) {
    while (const DynamicSample sample = subscriber.take()) {
      if (const Result<void> ok = printer.print(sample); !ok) return tl::unexpected(ok.error());
      if (++printed == options.count || stop.wait_for(std::chrono::nanoseconds(0))) return printed;
    }
    const bool for_ever = options.count == 0 || printed > 0;
    const auto left = for_ever ? Clock::duration(std::chrono::hours(1)) : given_up_at - Clock::now();
    if (left <= left.zero()) break;
    stop.wait_for(left, subscriber.file_descriptor());
  }
  return printed;
}

}  // namespace

ExitCode run(const EchoOptions& options, const CommonOptions& common, Session& session) {
  const Result<FoundTopic> topic = session.find(options.topic);
  if (!topic) return give_up(topic.error());
  const TypeSupport& type = topic->type.support();
  const Result<FieldMask> fields = all_fields(options, type);
  if (!fields) return give_up(fields.error());
  Result<DynamicSubscriber> subscriber = subscribe(options, *topic, session.node());
  if (!subscriber) return give_up(subscriber.error());
  Printer printer(options, *topic, *fields, session.output());
  const auto printed = print_samples(options, common, *subscriber, printer, session.stop());
  if (!printed) return give_up(printed.error());
  std::uint64_t lost = 0;
  for (std::size_t i = 0; i < options.fields.size(); ++i) lost += subscriber->status(i).lost;
  if (lost > 0)
    complain(fmt::format(
        "{} samples of '{}' were lost: they arrive faster than they are printed, or got lost on the way.",
        lost, topic->name));
  if (*printed > 0) return ExitCode::done;
  if (!session.stop().requested())
    complain(
        fmt::format("No sample of '{}' came within {:g} s; 'sft why {}' shows the state of its publishers.",
                    topic->name, common.timeout_s, topic->name));
  return ExitCode::nothing;
}

}  // namespace sft::tool
