// `sft bag estimate`: computes the bytes of a recording by topic and field, and how many of them selections
// would have saved.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "tools/recording/estimate.h"
#include "tools/recording/sample_type.h"
#include "tools/sft/bag.h"
#include "tools/sft/session.h"
#include "tools/sft/topic_selection.h"
#include "tools/terminal/file_error.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using recording::TopicEstimate;
using EstimateJson = nlohmann::ordered_json;

constexpr std::size_t fields_shown = 8;  // per topic, in text; pages show all fields
constexpr double percent = 100;

struct EstimatedTopic {
  std::string topic;
  std::string selection;  ///< the selection in the user's spelling; empty: the topic has none
  std::unique_ptr<TopicEstimate> estimate;
};

/// The topics of a recording. Channels with the same topic and type count as one topic.
class Estimate {
 public:
  Estimate(const std::vector<TopicSelection>& like, const CommonOptions& common)
      : like_(like), types_(common) {}

  /// Returns an error if a selection does not fit its topic's type.
  Result<void> add_channels(const recording::Recording& bag);
  void count(recording::Recording& bag, Stop& stop);

  /// The topics. After count(), they are sorted by size, the largest first.
  const std::vector<EstimatedTopic>& topics() const { return topics_; }
  std::vector<std::string> faults() const { return {faults_.begin(), faults_.end()}; }
  std::uint64_t sum(std::uint64_t (TopicEstimate::*of)() const) const {
    std::uint64_t sum = 0;
    for (const EstimatedTopic& topic : topics_) sum += (*topic.estimate.*of)();
    return sum;
  }

 private:
  const std::vector<TopicSelection>& like_;
  RecordedTypes types_;
  std::vector<EstimatedTopic> topics_;
  std::map<std::uint16_t, std::size_t> of_channel_;
  /// Indices into topics_, by topic and hash of the type
  std::map<std::pair<std::string, std::uint64_t>, std::size_t> of_topic_;
  std::set<std::string> faults_;
};

Result<void> Estimate::add_channels(const recording::Recording& bag) {
  for (const auto& [id, channel] : bag.channels()) {
    const auto schema = bag.schemas().find(channel.schema);
    if (of_channel_.contains(id) || schema == bag.schemas().end()) continue;
    const std::string topic = Session::plain_name(channel.topic);
    const Result<DynamicType>& type = types_.find(schema->second);
    if (!type) {
      faults_.insert(fmt::format("topic '{}' is left out: {}", topic, type.error().message));
      continue;
    }
    const auto [known, is_new] = of_topic_.try_emplace({topic, type->hash()}, topics_.size());
    of_channel_[id] = known->second;
    if (!is_new) continue;
    const auto like = std::ranges::find(like_, topic, &TopicSelection::topic);
    std::optional<Selection> selection;
    if (like != like_.end()) {
      const Result<Selection> parsed = recording::selection_of(*type, like->text);
      if (!parsed) return fail(parsed.error().code, "topic '" + topic + "': " + parsed.error().message);
      selection = *parsed;
    }
    topics_.push_back({topic, like == like_.end() ? "" : like->text,
                       std::make_unique<TopicEstimate>(*type, selection ? &*selection : nullptr)});
  }
  return {};
}

void Estimate::count(recording::Recording& bag, Stop& stop) {
  bag.rewind();
  while (const std::optional<recording::Message> message = bag.next()) {
    if (stop.wait_for(std::chrono::nanoseconds(0))) break;
    const auto topic = of_channel_.find(message->channel);
    if (topic == of_channel_.end()) continue;
    EstimatedTopic& one = topics_[topic->second];
    const Result<void> added = one.estimate->add(message->data, message->log_ns);
    if (!added)
      faults_.insert(fmt::format("topic '{}': a message is left out: {}", one.topic, added.error().message));
  }
  std::ranges::stable_sort(topics_, [](const EstimatedTopic& a, const EstimatedTopic& b) {
    return a.estimate->bytes() > b.estimate->bytes();
  });
}

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// Returns how much the selections save in all topics together, or the reason why that is not known.
std::string sum_text(const Estimate& estimate) {
  const std::uint64_t bytes = estimate.sum(&TopicEstimate::bytes);
  const std::uint64_t selected = estimate.sum(&TopicEstimate::selected_bytes);
  const bool has_samples = estimate.sum(&TopicEstimate::samples) > 0;
  if (!has_samples && estimate.faults().empty()) return "nothing to estimate: the recording has no messages";
  if (!has_samples)
    return fmt::format("nothing to estimate, since no message could be read: {}",
                       fmt::join(estimate.faults(), "; "));
  return fmt::format("all: {}; with the selections {}, {:.1f} % less", bytes_text(static_cast<double>(bytes)),
                     bytes_text(static_cast<double>(selected)), percent * share(bytes - selected, bytes));
}

void print_text(const Estimate& estimate, Output& output) {
  const std::uint64_t bytes = estimate.sum(&TopicEstimate::bytes);
  for (const EstimatedTopic& topic : estimate.topics()) {
    const TopicEstimate& one = *topic.estimate;
    output.line(output.colored(
        printable(fmt::format("{}: {}, {}, {:.1f} % of all", topic.topic, count_text(one.samples(), "sample"),
                              bytes_text(static_cast<double>(one.bytes())),
                              percent * share(one.bytes(), bytes))),
        Color::bold));
    if (!topic.selection.empty())
      output.line(printable(fmt::format("  {{{}}}: {}, {}, {:.1f} % of the topic", topic.selection,
                                        count_text(one.selected_samples(), "sample"),
                                        bytes_text(static_cast<double>(one.selected_bytes())),
                                        percent * share(one.selected_bytes(), one.bytes()))));
    std::size_t shown = 0;
    for (const TopicEstimate::Field& field : one.fields()) {
      if (++shown > fields_shown) break;
      output.line(fmt::format("  {:>10} {:>6.1f} %  {}", aligned_bytes_text(static_cast<double>(field.bytes)),
                              percent * share(field.bytes, one.bytes()), field.path));
    }
  }
  output.line(printable(sum_text(estimate)));
}

EstimateJson to_json(const Estimate& estimate) {
  EstimateJson topics = EstimateJson::array();
  for (const EstimatedTopic& topic : estimate.topics()) {
    const TopicEstimate& one = *topic.estimate;
    EstimateJson fields = EstimateJson::object();
    for (const TopicEstimate::Field& field : one.fields()) fields[field.path] = field.bytes;
    topics.push_back({{"topic", topic.topic},
                      {"type", recording::ros_type_name(one.type().name())},
                      {"samples", one.samples()},
                      {"bytes", one.bytes()},
                      {"selection", topic.selection},
                      {"selected_samples", one.selected_samples()},
                      {"selected_bytes", one.selected_bytes()},
                      {"fields", std::move(fields)}});
  }
  return {{"bytes", estimate.sum(&TopicEstimate::bytes)},
          {"selected_bytes", estimate.sum(&TopicEstimate::selected_bytes)},
          {"topics", std::move(topics)},
          {"faults", estimate.faults()}};
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const std::string_view special = c == '<'   ? "&lt;"
                                     : c == '>' ? "&gt;"
                                     : c == '&' ? "&amp;"
                                     : c == '"' ? "&quot;"
                                                : "";
    if (special.empty())
      out += c;
    else
      out += special;
  }
  return out;
}

/// Returns a line of a page: a name, a number of bytes, and a bar for it. A bar of the full length stands
/// for `most` bytes.
std::string bar(const std::string& name, std::uint64_t bytes, std::uint64_t selected, std::uint64_t most) {
  return fmt::format(
      "<tr><td>{}</td><td class=n>{}</td><td><div class=all style='width:{:.2f}%'>"
      "<div class=some style='width:{:.2f}%'></div></div></td></tr>\n",
      escaped(name), bytes_text(static_cast<double>(bytes)), percent * share(bytes, most),
      percent * share(selected, bytes));
}

std::string to_page(const Estimate& estimate, const std::string& title) {
  std::uint64_t most = 0;
  for (const EstimatedTopic& topic : estimate.topics()) most = std::max(most, topic.estimate->bytes());
  std::string page = fmt::format(
      "<!doctype html><meta charset=utf-8><title>{0}</title>\n"
      "<style>body{{font:14px "
      "sans-serif;margin:2em;max-width:70em}}table{{width:100%;border-collapse:collapse}}"
      "td{{padding:2px 8px}}td:last-child{{width:60%}}.n{{text-align:right;white-space:nowrap}}"
      ".all{{background:#cbd5e1;height:14px}}.some{{background:#2563eb;height:14px}}</style>\n"
      "<h1>{0}</h1>\n<p>{1}. Grey is what was recorded, blue what the selections need.</p>\n<table>\n",
      escaped(title), escaped(sum_text(estimate)));
  for (const EstimatedTopic& topic : estimate.topics())
    page += bar(topic.topic, topic.estimate->bytes(), topic.estimate->selected_bytes(), most);
  page += "</table>\n";
  for (const EstimatedTopic& topic : estimate.topics()) {
    page += fmt::format("<h2>{}</h2>\n<p>{}{}</p>\n<table>\n", escaped(topic.topic),
                        count_text(topic.estimate->samples(), "sample"),
                        topic.selection.empty() ? "" : ", selection " + escaped(topic.selection));
    for (const TopicEstimate::Field& field : topic.estimate->fields())
      page += bar(field.path, field.bytes, 0, topic.estimate->bytes());
    page += "</table>\n";
  }
  return page;
}

}  // namespace

ExitCode run_estimate(const BagOptions& options, const CommonOptions& common, recording::Recording& bag,
                      Stop& stop, Output& output) {
  std::vector<TopicSelection> like;
  for (const std::string& text : options.like) {
    Result<TopicSelection> parsed = parse_topic_selection(text);
    if (!parsed) {
      complain(parsed.error().message);
      return ExitCode::failed;
    }
    like.push_back(*std::move(parsed));
  }
  (void)bag.overview();  // the channels of an unfinished file are known only after it was read
  Estimate estimate(like, common);
  if (const Result<void> added = estimate.add_channels(bag); !added) {
    complain(added.error().message);
    return ExitCode::failed;
  }
  estimate.count(bag, stop);
  if (stop.requested()) {
    complain("Interrupted: the figures of a part are not those of the whole.");
    return ExitCode::failed;
  }
  if (common.json)
    output.document(to_json(estimate));
  else
    print_text(estimate, output);
  const bool is_reported = !common.json && estimate.sum(&TopicEstimate::samples) == 0;
  if (!is_reported)
    for (const std::string& fault : estimate.faults()) complain(printable(fault));
  for (const TopicSelection& one : like) {
    if (std::ranges::find(estimate.topics(), one.topic, &EstimatedTopic::topic) == estimate.topics().end())
      complain(printable(fmt::format("The recording has no topic '{}'.", one.topic)));
  }
  if (!options.html.empty()) {
    std::ofstream page(options.html);
    page << to_page(estimate, options.files.front());
    if (!page.flush()) {
      complain(cannot_be_written(options.html).message);
      return ExitCode::failed;
    }
  }
  return estimate.sum(&TopicEstimate::samples) == 0 ? ExitCode::nothing : ExitCode::done;
}

}  // namespace sft::tool
