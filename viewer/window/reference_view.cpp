#include "window/reference_view.h"

namespace fumarole::window {

bool ReferenceView::asked_for(const Scene& scene, double tolerance, int bounces) const
{
    return request_ && request_->tolerance == tolerance && request_->bounces == bounces &&
           request_->scene.resolution == scene.resolution &&
           request_->scene.camera == scene.camera && request_->scene.time == scene.time &&
           same_content(request_->scene, scene);
}

void ReferenceView::follow(const Scene& scene, double tolerance, int bounces, bool moving,
                           double now)
{
    // To copy the whole picture for each tile would cost more than the tiles do.
    constexpr double kInterval = 0.2;  // [s]
    if (!asked_for(scene, tolerance, bounces)) {
        worker_.stop();
        request_.reset();
        errors_.clear();
        if (moving)
            return;
        worker_.start(scene, tolerance, bounces);
        request_ = {scene, tolerance, bounces};
    }
    if (picture_.version != 0 && busy() && now - taken_ < kInterval)
        return;
    taken_ = now;
    worker_.update(picture_);
}

void ReferenceView::drop()
{
    worker_.stop();
    request_.reset();
    picture_ = {};
    errors_.clear();
}

Image ReferenceView::image() const
{
    Image image;
    image.width = picture_.width;
    image.height = picture_.height;
    image.channels = {"R", "G", "B"};
    image.pixels = picture_.composite;
    return image;
}

void ReferenceView::measure(const std::vector<std::pair<std::string, Image>>& pictures)
{
    measured_ = picture_.version;
    errors_.clear();
    for (const auto& [name, image] : pictures)
        if (image.pixels.size() == picture_.composite.size())
            errors_.push_back(
                {name, study::compare(image.pixels, picture_.composite, picture_.done, 3)});
}

}  // namespace fumarole::window
