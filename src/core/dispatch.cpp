#include <cstdlib>
#include <cstring>

#include "kernels.hpp"

namespace pinchoff {

extern const Kernels kernels_generic;
#if defined(PINCHOFF_X86_LEVELS)
extern const Kernels kernels_x86_64_v3;
extern const Kernels kernels_x86_64_v4;
#endif

static const Kernels& choose() {
    const char* wish = std::getenv("PINCHOFF_INSTRUCTION_SET");
    [[maybe_unused]] const auto allowed = [&](const Kernels& k) {
        return wish == nullptr || *wish == '\0' || std::strcmp(wish, k.name) == 0;
    };
#if defined(PINCHOFF_X86_LEVELS)
    __builtin_cpu_init();
    const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                    __builtin_cpu_supports("bmi2");
    const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                    __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                    __builtin_cpu_supports("avx512vl");
    if (v4 && allowed(kernels_x86_64_v4)) return kernels_x86_64_v4;
    if (v3 && allowed(kernels_x86_64_v3)) return kernels_x86_64_v3;
#endif
    return kernels_generic;
}

const Kernels& best_kernels() {
    static const Kernels& best = choose();
    return best;
}

}  // namespace pinchoff
