#pragma once

#include <cstddef>
#include <functional>
#include <string_view>
#include <vector>

namespace fumarole {

/// Where a host keeps programs as its driver has compiled them, so that another run need not
/// compile them again. Without one every Renderer compiles all that it draws with: the library
/// itself opens no file. Neither function may throw; both are called with the context current, on
/// the thread of the call that needs a program.
struct ProgramStore {
    /// What was stored by this key, or nothing. The key is 32 hexadecimal digits, made of the
    /// program's sources and of the driver's name and version. Bytes that are damaged, or that the
    /// driver does not want any more, are no harm: the program is compiled, and stored again.
    std::function<std::vector<std::byte>(std::string_view key)> load;
    /// Called once a program is compiled, where this driver gives programs away.
    std::function<void(std::string_view key, const std::vector<std::byte>& program)> store;

    explicit operator bool() const { return load && store; }
};

}  // namespace fumarole
