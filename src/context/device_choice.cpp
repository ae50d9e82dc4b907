#include "context/device_choice.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace fumarole::gl {

namespace {

std::string lower(std::string text)
{
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

bool is_number(const std::string& text)
{
    return std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
}

/// Looks at each device once at most.
class Looks {
public:
    Looks(std::size_t count, const LookAtDevice& look) : look_{look}, seen_(count) {}

    [[nodiscard]] std::size_t count() const { return seen_.size(); }
    const DeviceDescription& at(std::size_t i)
    {
        if (!seen_[i])
            seen_[i] = look_(i);
        return *seen_[i];
    }
    std::string named(std::size_t i) { return fmt::format("{} ({})", i, at(i).name); }

    /// For a message: what there is to choose from.
    std::string all_named()
    {
        if (count() == 0)
            return "EGL lists no device here";
        std::vector<std::string> names;
        for (std::size_t i = 0; i < count(); ++i)
            names.push_back(named(i));
        return fmt::format("there {}: {}", count() == 1 ? "is" : "are", fmt::join(names, ", "));
    }

private:
    const LookAtDevice& look_;
    std::vector<std::optional<DeviceDescription>> seen_;
};

DeviceChoice choose_named(const std::string& wanted, Looks& devices)
{
    std::vector<std::size_t> matches;
    if (is_number(wanted)) {
        std::size_t number = devices.count();
        std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
        if (number < devices.count())
            matches.push_back(number);
    } else {
        for (std::size_t i = 0; i < devices.count(); ++i)
            if (lower(devices.at(i).name).find(lower(wanted)) != std::string::npos)
                matches.push_back(i);
    }
    if (matches.empty())
        throw NoSuchDevice(fmt::format("--device: no '{}'; {}", wanted, devices.all_named()));
    for (const std::size_t i : matches)
        if (devices.at(i).refusal.empty())
            return {i, fmt::format("EGL's device {}, as asked for", i), {}};
    throw Error(fmt::format("--device: {} can't be used: {}; `fumarole info --devices` tells of "
                            "all",
                            devices.named(matches.front()), devices.at(matches.front()).refusal));
}

}  // namespace

DeviceChoice choose_device(const DeviceRequest& request, const std::vector<bool>& software,
                           const LookAtDevice& look)
{
    if (request.backend == Backend::osmesa)
        return {std::nullopt, "OSMesa, as asked for", {}};
    Looks devices(software.size(), look);
    if (!request.device.empty())
        return choose_named(request.device, devices);

    std::vector<std::string> failures;
    for (std::size_t i = 0; i < devices.count(); ++i) {
        if (software[i] || devices.at(i).software)
            continue;
        if (devices.at(i).refusal.empty())
            return {i,
                    fmt::format("EGL's device {}, {}", i,
                                devices.count() == 1
                                    ? "a GPU"
                                    : fmt::format("the first GPU that works of {} devices",
                                                  devices.count())),
                    {}};
        failures.push_back(
            fmt::format("device {} can't be used: {}", devices.named(i), devices.at(i).refusal));
    }
    const std::string no_gpu = devices.count() == 0 ? "EGL lists no device"
                               : failures.empty()   ? "EGL lists no GPU"
                                                    : "no GPU that works";
    if (request.backend == Backend::automatic)
        return {std::nullopt, fmt::format("OSMesa: {}", no_gpu), std::move(failures)};

    for (std::size_t i = 0; i < devices.count(); ++i) {
        if (!software[i] && !devices.at(i).software)
            continue;
        if (devices.at(i).refusal.empty())
            return {i, fmt::format("EGL's device {}, a rasteriser: {}", i, no_gpu),
                    std::move(failures)};
        failures.push_back(
            fmt::format("device {} can't be used: {}", devices.named(i), devices.at(i).refusal));
    }
    throw Error(failures.empty()
                    ? "EGL: no device and no display without a window system; a driver with "
                      "EGL_EXT_platform_device or EGL_MESA_platform_surfaceless is needed, or "
                      "use --backend osmesa"
                    : fmt::format("EGL: {}; update the driver, or use --backend osmesa",
                                  fmt::join(failures, "; ")));
}

}  // namespace fumarole::gl
