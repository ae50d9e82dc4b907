#include "coming_scene.h"

#include <algorithm>
#include <utility>

#include <fumarole/live_scene.h>

namespace fumarole {

bool ComingScene::is(const Scene& scene) const
{
    return scene_ && same_content(*scene_, scene);
}

void ComingScene::await(const Scene& scene, const SceneSettings& settings)
{
    settings_ = settings;
    if (!sending_)
        begin_sending(scene);
    scene_ = scene;
    send_part();
}

void ComingScene::begin_sending(const Scene& scene)
{
    media_.begin_sending(scene, settings_);
    sending_.emplace(Sending{scene.media, scene.time});
}

void ComingScene::send_part()
{
    const std::uint64_t left = limit_ - std::min(sent_in_frame_, limit_);
    sent_in_frame_ += media_.send(left, sent_in_frame_ == 0);
}

void ComingScene::show_what_came(const Show& show)
{
    if (!sending_ || media_.is_sending())
        return;
    const Sending came = std::move(*std::exchange(sending_, std::nullopt));
    if (!scene_)
        return;
    const Scene wanted = std::move(*std::exchange(scene_, std::nullopt));
    if (media_.has_grids(wanted, settings_)) {
        show(wanted);
        return;
    }
    Scene next = wanted;  // the scene was another when these were begun
    next.media = came.media;
    next.time = came.time;
    show(next);
    begin_sending(wanted);
    scene_ = wanted;
}

void ComingScene::end_frame()
{
    send_part();
    sent_in_frame_ = 0;
}

void ComingScene::finish(const Show& show)
{
    if (!scene_)
        return;
    show(*std::exchange(scene_, std::nullopt));
    forget();
}

void ComingScene::forget()
{
    media_.begin_sending({}, {});
    sending_.reset();
    scene_.reset();
}

}  // namespace fumarole
