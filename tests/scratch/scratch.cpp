#include "benchmarks/stability/bundle_cases.h"
#include <cstdio>
int main() { for (const auto& r : cousin::bundle_cases(true)) std::printf("%s | %s | %g (limit %g) %s\n", r.case_name.c_str(), r.quantity.c_str(), r.value, r.limit, r.pass ? "pass" : "-"); }
