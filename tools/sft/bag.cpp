#include "tools/sft/bag.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tools/recording/mcap_writer.h"
#include "tools/recording/qos_profile.h"
#include "tools/sft/definitions.h"
#include "tools/sft/session.h"
#include "tools/sft/table.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using recording::Channel;
using recording::Overview;
using recording::Recording;
using BagJson = nlohmann::ordered_json;

using namespace std::chrono_literals;

constexpr double ns_per_s = 1e9;

double span_s(const Overview& overview) {
  return static_cast<double>(overview.last_ns - overview.first_ns) / ns_per_s;
}

std::string time_text(std::uint64_t ns) {
  constexpr std::uint64_t ms = 1'000'000, per_second = 1000;
  const std::chrono::sys_seconds time{std::chrono::seconds(ns / ms / per_second)};
  return fmt::format("{:%F %T}.{:03} UTC", time, ns / ms % per_second);
}

/// A row of the table of a recording's channels, or of the same list as JSON.
struct ChannelRow {
  std::string topic, type;
  std::uint64_t messages;
  Qos qos;
  std::string node, selection;
};

std::vector<ChannelRow> rows_of(Recording& bag) {
  std::vector<ChannelRow> rows;
  const Overview& overview = bag.overview();
  for (const auto& [id, channel] : bag.channels()) {
    const auto text = [&](const char* key) { return recording::value_of(channel.metadata, key); };
    const auto schema = bag.schemas().find(channel.schema);
    const auto count = overview.of_channel.find(id);
    rows.push_back({channel.topic, schema == bag.schemas().end() ? "unknown" : schema->second.name,
                    count == overview.of_channel.end() ? 0 : count->second,
                    recording::from_profiles(text("offered_qos_profiles")), text("sft_node"),
                    text("sft_selection")});
  }
  std::ranges::stable_sort(rows, {}, &ChannelRow::topic);
  return rows;
}

std::string offer_text(const Qos& qos) {
  std::string text = to_string(qos.reliability);
  if (qos.durability == transient_local) text += fmt::format(", keeps {}", qos.history_depth);
  return text;
}

void print_json(const std::string& path, std::uint64_t size, Recording& bag, Output& output) {
  const Overview& overview = bag.overview();
  BagJson channels = BagJson::array();
  for (const ChannelRow& row : rows_of(bag)) {
    channels.push_back({{"topic", row.topic},
                        {"type", row.type},
                        {"messages", row.messages},
                        {"reliability", to_string(row.qos.reliability)},
                        {"durability", to_string(row.qos.durability)},
                        {"node", row.node},
                        {"selection", row.selection}});
  }
  output.document({{"file", path},
                   {"format", bag.format()},
                   {"bytes", size},
                   {"messages", overview.messages},
                   {"first_ns", overview.first_ns},
                   {"last_ns", overview.last_ns},
                   {"chunks", overview.chunks},
                   {"attachments", overview.attachments},
                   {"metadata", overview.metadata},
                   {"channels", std::move(channels)},
                   {"faults", bag.faults()}});
}

void print_info(const std::string& path, std::uint64_t size, Recording& bag, Output& output) {
  const Overview& overview = bag.overview();
  output.line(
      printable(fmt::format("{}: {}, {}", path, bag.format(), bytes_text(static_cast<double>(size)))));
  output.line(overview.messages == 0
                  ? "no messages"
                  : fmt::format("{}, {:.3f} s from {} on", count_text(overview.messages, "message"),
                                span_s(overview), time_text(overview.first_ns)));
  for (const auto& [compression, count] : overview.chunks)
    output.line(printable(fmt::format("{}, compression {}", count_text(count, "chunk"), compression)));
  for (const auto& [name, bytes] : overview.attachments)
    output.line(printable(fmt::format("attachment '{}', {}", name, bytes_text(static_cast<double>(bytes)))));
  for (const auto& [name, texts] : overview.metadata) {
    for (const auto& [key, value] : texts)
      output.line(printable(fmt::format("{}: {}: {}", name, key, value)));
  }
  Table table({"TOPIC", "TYPE", "MESSAGES", "RATE", "QOS", "SELECTION"});
  for (const ChannelRow& row : rows_of(bag)) {
    const double rate = span_s(overview) > 0 ? static_cast<double>(row.messages) / span_s(overview) : 0;
    table.add({printable(row.topic), printable(row.type), std::to_string(row.messages),
               rate > 0 ? rate_text(rate) : "-", offer_text(row.qos), printable(row.selection)});
  }
  if (!table.empty()) table.print(output);
}

ExitCode check(const std::string& path, Recording& bag, const CommonOptions& common, Output& output) {
  bag.check();
  const std::uint64_t messages = bag.overview().messages;
  if (common.json) {
    output.record({{"file", path}, {"messages", messages}, {"faults", bag.faults()}});
  } else if (bag.faults().empty()) {
    output.line(printable(fmt::format("{}: all is well: {}", path, count_text(messages, "message"))));
  } else {
    for (const std::string& fault : bag.faults()) output.line(printable(path + ": " + fault));
    output.line(
        printable(fmt::format("{}: {}; {} can be read", path, count_text(bag.faults().size(), "fault"),
                              count_text(messages, "message"))));
  }
  return bag.faults().empty() ? ExitCode::done : ExitCode::failed;
}

ExitCode interrupted() {
  complain("Interrupted.");
  return ExitCode::failed;
}

/// Copies all messages that can be read into a new file, and checks the new file.
Result<void> copy_to(recording::McapWriter& writer, Recording& bag, std::uint64_t& messages) {
  bag.rewind();
  while (const std::optional<recording::Message> message = bag.next()) {
    if (!writer.has_channel(message->channel)) {
      const Channel& channel = bag.channels().at(message->channel);
      if (const auto schema = bag.schemas().find(channel.schema); schema != bag.schemas().end())
        writer.declare(schema->second);
      writer.declare(channel);
    }
    if (const Result<void> done = writer.write(*message); !done) return done;
    ++messages;
  }
  Result<void> attached;
  bag.read_attachments([&](const recording::Bytes& attachment) {
    if (attached) attached = writer.write_attachment(attachment);
  });
  if (!attached) return attached;
  for (const auto& [name, texts] : bag.overview().metadata) {
    if (const Result<void> done = writer.write_metadata(name, texts); !done) return done;
  }
  return writer.close();
}

ExitCode repair(const BagOptions& options, const std::string& path, Recording& bag, Stop& stop,
                Output& output) {
  if (options.output.empty()) {
    complain("Name the new file with --output.");
    return ExitCode::failed;
  }
  std::uint64_t messages = 0;
  Result<recording::McapWriter> writer = recording::McapWriter::create(options.output, {});
  const Result<void> copied =
      writer ? copy_to(*writer, bag, messages) : Result<void>(tl::unexpected(writer.error()));
  if (!copied) {
    complain(printable(copied.error().message + "."));
    return ExitCode::failed;
  }
  if (stop.requested()) return interrupted();
  for (const std::string& fault : bag.faults()) output.line(printable(path + ": " + fault));
  const Result<std::unique_ptr<Recording>> made = recording::open_recording(options.output);
  if (made) (*made)->set_is_stopped([&stop] { return stop.wait_for(0ns); });
  if (made) (*made)->check();
  if (stop.requested()) return interrupted();
  if (!made || !(*made)->faults().empty() || (*made)->overview().messages != messages) {
    complain(printable(fmt::format("'{}' is not what was written: {}.", options.output,
                                   !made                       ? made.error().message
                                   : (*made)->faults().empty() ? "messages are missing"
                                                               : (*made)->faults().front())));
    return ExitCode::failed;
  }
  output.line(printable(
      fmt::format("{}: {} written and read again", options.output, count_text(messages, "message"))));
  return ExitCode::done;
}

ExitCode run_one(const BagOptions& options, const CommonOptions& common, const std::string& path, Stop& stop,
                 Output& output) {
  Result<std::unique_ptr<Recording>> bag = recording::open_recording(path);
  if (!bag) return give_up({bag.error().code, printable(bag.error().message)});
  (*bag)->set_is_stopped([&stop] { return stop.wait_for(0ns); });
  if (options.what == "check") return check(path, **bag, common, output);
  if (options.what == "repair") return repair(options, path, **bag, stop, output);
  if (options.what == "estimate") {
    const ExitCode code = run_estimate(options, common, **bag, stop, output);
    for (const std::string& fault : (*bag)->faults()) complain(printable(path + ": " + fault));
    return code;
  }
  std::error_code ignored;
  const std::uint64_t size = std::filesystem::file_size(path, ignored);
  (void)(*bag)->overview();
  if (stop.requested()) return interrupted();
  if (common.json) {
    print_json(path, size, **bag, output);
  } else {
    print_info(path, size, **bag, output);
    for (const std::string& fault : (*bag)->faults()) complain(printable(path + ": " + fault));
  }
  return ExitCode::done;
}

}  // namespace

const Result<DynamicType>& RecordedTypes::find(const recording::Schema& schema, std::size_t file) {
  const std::pair key{file, schema.id};
  if (const auto known = found_.find(key); known != found_.end()) return known->second;
  Result<DynamicType> type = recording::type_of(schema);
  if (!type && type.error().code == Errc::unavailable) {
    const std::string why = type.error().message + "; ";
    type = find_definition(schema.name, common_).map_error([&](const Error& of_files) {
      return Error{of_files.code, why + of_files.message};
    });
  }
  return found_.emplace(key, std::move(type)).first->second;
}

ExitCode run(const BagOptions& options, const CommonOptions& common, Stop& stop, Output& output) {
  ExitCode worst = ExitCode::done;
  std::vector<std::string> paths;
  for (const std::string& given : options.files) {
    const Result<std::vector<std::string>> files = recording::files_of(given);
    if (!files) {
      complain(printable(files.error().message));
      worst = ExitCode::failed;
      continue;
    }
    paths.insert(paths.end(), files->begin(), files->end());
  }
  if (paths.size() > 1 && !(options.output.empty() && options.html.empty())) {
    complain("A new file is made from one recording only: name one of the files.");
    return ExitCode::failed;
  }
  for (const std::string& path : paths) {
    if (stop.requested()) return interrupted();
    worst = std::max(worst, run_one(options, common, path, stop, output));
  }
  return worst;
}

}  // namespace sft::tool
