#include <fumarole/live_scene.h>

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include <fumarole/errors.h>

namespace fumarole {

namespace {

const char* word_for(LightId)
{
    return "light";
}
const char* word_for(MediumId)
{
    return "medium";
}
const char* word_for(SurfaceId)
{
    return "surface";
}
const char* word_for(TransparentId)
{
    return "transparent";
}
const char* word_for(ProbeId)
{
    return "probe";
}

/// @param member for the message
template <class Part>
std::size_t index_of(const std::vector<PartId<Part>>& ids, PartId<Part> id, const char* member)
{
    const auto at = std::find(ids.begin(), ids.end(), id);
    if (at == ids.end())
        throw Error(fmt::format("LiveScene::{}: {} {} is no part of this scene: it was removed, or "
                                "is another scene's; add() it anew",
                                member, word_for(id), id.number));
    return static_cast<std::size_t>(at - ids.begin());
}

template <class Part>
void erase(std::vector<Part>& parts, std::vector<PartId<Part>>& ids, PartId<Part> id)
{
    const auto index = static_cast<std::ptrdiff_t>(index_of(ids, id, "remove"));
    parts.erase(parts.begin() + index);
    ids.erase(ids.begin() + index);
}

}  // namespace

LiveScene::LiveScene(Scene scene) : scene_{std::move(scene)}
{
    for (std::size_t i = 0; i < scene_.lights.size(); ++i)
        lights_.push_back({++last_});
    for (std::size_t i = 0; i < scene_.media.size(); ++i)
        media_.push_back({++last_});
    for (std::size_t i = 0; i < scene_.surfaces.size(); ++i)
        surfaces_.push_back({++last_});
    for (std::size_t i = 0; i < scene_.transparents.size(); ++i)
        transparents_.push_back({++last_});
    for (std::size_t i = 0; i < scene_.probes.size(); ++i)
        probes_.push_back({++last_});
}

LightId LiveScene::add(Light light)
{
    scene_.lights.push_back(light);
    return lights_.emplace_back(LightId{++last_});
}

MediumId LiveScene::add(Medium medium)
{
    scene_.media.push_back(std::move(medium));
    return media_.emplace_back(MediumId{++last_});
}

SurfaceId LiveScene::add(Surface surface)
{
    scene_.surfaces.push_back(std::move(surface));
    return surfaces_.emplace_back(SurfaceId{++last_});
}

TransparentId LiveScene::add(Transparent transparent)
{
    scene_.transparents.push_back(std::move(transparent));
    return transparents_.emplace_back(TransparentId{++last_});
}

ProbeId LiveScene::add(LightProbe probe)
{
    scene_.probes.push_back(probe);
    return probes_.emplace_back(ProbeId{++last_});
}

void LiveScene::update(LightId id, Light light)
{
    scene_.lights[index_of(lights_, id, "update")] = light;
}

void LiveScene::update(MediumId id, Medium medium)
{
    scene_.media[index_of(media_, id, "update")] = std::move(medium);
}

void LiveScene::update(SurfaceId id, Surface surface)
{
    scene_.surfaces[index_of(surfaces_, id, "update")] = std::move(surface);
}

void LiveScene::update(TransparentId id, Transparent transparent)
{
    scene_.transparents[index_of(transparents_, id, "update")] = std::move(transparent);
}

void LiveScene::update(ProbeId id, LightProbe probe)
{
    scene_.probes[index_of(probes_, id, "update")] = probe;
}

void LiveScene::remove(LightId id)
{
    erase(scene_.lights, lights_, id);
}

void LiveScene::remove(MediumId id)
{
    erase(scene_.media, media_, id);
}

void LiveScene::remove(SurfaceId id)
{
    erase(scene_.surfaces, surfaces_, id);
}

void LiveScene::remove(TransparentId id)
{
    erase(scene_.transparents, transparents_, id);
}

void LiveScene::remove(ProbeId id)
{
    erase(scene_.probes, probes_, id);
}

const Light& LiveScene::at(LightId id) const
{
    return scene_.lights[index_of(lights_, id, "at")];
}

const Medium& LiveScene::at(MediumId id) const
{
    return scene_.media[index_of(media_, id, "at")];
}

const Surface& LiveScene::at(SurfaceId id) const
{
    return scene_.surfaces[index_of(surfaces_, id, "at")];
}

const Transparent& LiveScene::at(TransparentId id) const
{
    return scene_.transparents[index_of(transparents_, id, "at")];
}

const LightProbe& LiveScene::at(ProbeId id) const
{
    return scene_.probes[index_of(probes_, id, "at")];
}

void LiveScene::set_world(World world)
{
    scene_.world = std::move(world);
}

void LiveScene::set_time(double time)
{
    scene_.time = time;
}

}  // namespace fumarole
