// expect: a loan is gone once it is published: write std::move[(]loan[)][.]publish[(][)]
#include "tests/compile_fail/cloud.h"

auto misuse(sft::Loan<PointCloud2>& loan) { return loan.publish(); }
