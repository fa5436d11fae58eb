#include "bench/peers/csv.h"

#include <fmt/format.h>

#include <ostream>

namespace sft::bench::peers {

void write_csv(std::ostream& out, const Records& all) {
  out << "group,where,waiting,readers,contender,bytes,round,samples,p50_us,p90_us,p99_us,p999_us,paced_cpu_"
         "us,"
         "messages_per_s,fast_cpu_us,lost_share\n";
  for (const Record& r : all) {
    out << fmt::format("{},{},{},{},{},{},{},{},{:.2f},{:.2f},{:.2f},{:.2f},{:.2f},{:.1f},{:.2f},{:.4f}\n",
                       r.group, r.of.where == Where::one_host ? "one_host" : "two_hosts",
                       r.of.waiting == Waiting::sleeping ? "sleeping" : "spinning", r.of.readers,
                       id_of(r.entrant), r.bytes, r.round + 1, r.samples, r.p50_us, r.p90_us, r.p99_us,
                       r.p999_us, r.paced_cpu_us, r.per_s, r.fast_cpu_us, r.lost);
  }
  out << std::flush;  // an isolated program ends without destroying the stream
}

}  // namespace sft::bench::peers
