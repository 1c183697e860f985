// Benchmarks of the engine run, and refuse what they cannot measure.
#include <stdexcept>
#include <string>

#include "lab/bench/bench_image.h"
#include "support/check.h"

namespace motes::test_bench {

TEST(render_bench_runs) {
  const bench::RenderBench result = bench::render_bench(10000, 160, 90, 5, 2);
  CHECK(result.records > 5000 && result.ms_per_frame > 0 && result.ms_project > 0);
  bool with_bloom = false;
  for (const bench::RenderRow& row : result.rows) {
    CHECK(row.ms_per_frame > 0 && row.ratio > 0);
    with_bloom |= row.name.find("bloom") != std::string::npos;
  }
  CHECK(with_bloom);
  CHECK_THROWS(bench::render_bench(0, 160, 90, 5, 2), std::invalid_argument);
}

}  // namespace motes::test_bench
