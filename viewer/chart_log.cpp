#include "chart_log.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <fumarole/errors.h>

namespace fumarole::command {

namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity and writes null for it.
double number(const Json& json)
{
    return json.is_null() ? std::numeric_limits<double>::infinity() : json.get<double>();
}

Json to_json(const study::TargetError& e)
{
    return {e.relmse, e.relmse_min, e.relmse_max, e.bias_part, e.variance, e.bias};
}

study::TargetError target_error(const Json& json)
{
    return {number(json.at(0)), number(json.at(1)), number(json.at(2)),
            number(json.at(3)), number(json.at(4)), number(json.at(5))};
}

Json to_json(const study::ChartVisit& visit, const std::string& key)
{
    Json targets = Json::array();
    for (const study::TargetError& e : visit.errors.targets)
        targets.push_back(to_json(e));
    return {{"key", key},
            {"point", visit.point},
            {"round", visit.round},
            {"volume_ms", {visit.volume.min_ms, visit.volume.median_ms, visit.volume.max_ms}},
            {"frames", visit.frames},
            {"samples", visit.samples},
            {"gpu_bytes", visit.gpu_bytes},
            {"errors", targets},
            {"flip", visit.errors.flip},
            {"seeds", visit.errors.seeds},
            {"refusal", visit.refusal},
            {"seconds", visit.seconds}};
}

study::ChartVisit to_visit(const Json& json)
{
    study::ChartVisit visit;
    visit.point = json.at("point").get<std::string>();
    visit.round = json.at("round").get<int>();
    const Json& ms = json.at("volume_ms");
    visit.volume = {"volume", number(ms.at(0)), number(ms.at(1)), number(ms.at(2))};
    visit.frames = json.at("frames").get<int>();
    visit.samples = number(json.at("samples"));
    visit.gpu_bytes = json.at("gpu_bytes").get<std::uint64_t>();
    for (std::size_t t = 0; t < visit.errors.targets.size(); ++t)
        visit.errors.targets[t] = target_error(json.at("errors").at(t));
    visit.errors.flip = number(json.at("flip"));
    visit.errors.seeds = json.at("seeds").get<int>();
    visit.refusal = json.at("refusal").get<std::string>();
    visit.seconds = number(json.at("seconds"));
    return visit;
}

}  // namespace

ChartLog::ChartLog(std::filesystem::path file, std::string key)
    : file_{std::move(file)}, key_{std::move(key)}
{
}

std::vector<study::ChartVisit> ChartLog::read() const
{
    std::vector<study::ChartVisit> visits;
    std::ifstream stream(file_);
    for (std::string line; std::getline(stream, line);) {
        try {
            const Json json = Json::parse(line);
            if (json.at("key") == key_)
                visits.push_back(to_visit(json));
        } catch (const Json::exception&) {
            continue;  // torn, or of another program
        }
    }
    return visits;
}

void ChartLog::append(const study::ChartVisit& visit)
{
    std::string line =
        to_json(visit, key_).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    const int file = ::open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    char last = '\n';
    if (file >= 0)
        if (const off_t end = ::lseek(file, 0, SEEK_END); end > 0)
            if (::pread(file, &last, 1, end - 1) == 1 && last != '\n')
                line.insert(0, 1, '\n');  // after a torn line
    const bool written =
        file >= 0 && ::write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size());
    const int error = errno;
    if (file >= 0)
        ::close(file);
    if (!written)
        throw Error(fmt::format("{}: {}", file_.string(), std::strerror(error)));
}

}  // namespace fumarole::command
