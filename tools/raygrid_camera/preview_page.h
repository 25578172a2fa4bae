#ifndef RAYGRID_CAMERA_PREVIEW_PAGE_H
#define RAYGRID_CAMERA_PREVIEW_PAGE_H

namespace raygrid {

constexpr char kPreviewPage[] = R"(<!DOCTYPE html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<link rel="icon" href="data:,">
<title>raygrid-camera</title>
<style>
body { margin: 1rem; font: 1rem sans-serif; color: #222; background: #fff }
main { display: flex; flex-wrap: wrap; gap: 1rem }
figure { margin: 0; flex: 1 1 20rem }
img { width: 100%; background: #ddd }
</style>
<main>
<figure><figcaption>Camera</figcaption><img src="/before" alt="camera"></figure>
<figure><figcaption>Undistorted</figcaption><img src="/after" alt="undistorted"></figure>
</main>
</html>
)";

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PREVIEW_PAGE_H
