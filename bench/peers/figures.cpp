#include "bench/peers/figures.h"

#include <fmt/format.h>

#include <cmath>

namespace sft::bench::peers {

namespace {

struct Measure {
  const char* name;
  const char* unit;
  double Record::*value;
  double scale;
  bool more_is_better;
};

constexpr Measure measures[] = {{"p50", "us", &Record::p50_us, 1, false},
                                {"p99", "us", &Record::p99_us, 1, false},
                                {"cpu", "us", &Record::paced_cpu_us, 1, false},
                                {"rate", "k/s", &Record::per_s, 1e-3, true}};

double median_of(const Records& all, const Column& column, const Entrant& entrant, const Measure& measure) {
  return measure.scale * spread(records_of(all, column.of, entrant, column.bytes), measure.value).median;
}

Figure figure(const std::string& group, const Records& all, const Column& column, const Entrant& entrant,
              const Measure& measure) {
  Figure figure{.name = fmt::format("{}_{}_{}B_{}_{}", group, column.of.readers, column.bytes, id_of(entrant),
                                    measure.name),
                .value = median_of(all, column, entrant, measure),
                .unit = measure.unit};
  for (const Entrant& peer : entrants(column.of)) {
    const double theirs = median_of(all, column, peer, measure);
    if (peer.is_sft() || peer.way == Way::memcpy_alone || !std::isfinite(theirs)) continue;
    const bool better = figure.reference &&
                        (measure.more_is_better ? theirs > *figure.reference : theirs < *figure.reference);
    if (figure.reference && !better) continue;
    figure.reference = theirs;
    figure.reference_name = name_of(peer);
  }
  return figure;
}

}  // namespace

std::vector<Figure> figures(const std::string& group, const Records& all,
                            const std::vector<Column>& columns) {
  std::vector<Figure> figures;
  for (const Column& column : columns) {
    for (const Entrant& entrant : entrants(column.of)) {
      if (!entrant.is_sft()) continue;
      for (const Measure& measure : measures) {
        Figure one = figure(group, all, column, entrant, measure);
        if (std::isfinite(one.value)) figures.push_back(std::move(one));
      }
    }
  }
  return figures;
}

}  // namespace sft::bench::peers
