// expect: (has no non-static data member named|field designator) .fields
#include "tests/compile_fail/cloud.h"

auto misuse(sft::Publisher<PointCloud2>& publisher) {
  return publisher.loan({}, PointCloud2::LoanSizes{.fields = 3});
}
