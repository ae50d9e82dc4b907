#pragma once

namespace fumarole {

/// Functions in one, for std::visit: a kind that none of them takes fails to compile.
template <typename... Functions> struct Overloaded : Functions... {
    using Functions::operator()...;
};
template <typename... Functions> Overloaded(Functions...) -> Overloaded<Functions...>;

}  // namespace fumarole
