const dialog = document.querySelector("dialog");
const large = dialog.querySelector("img");
for (const picture of document.querySelectorAll(".picture")) {
  picture.addEventListener("click", (event) => {
    event.preventDefault();
    const shown = picture.querySelector("img");
    large.src = shown.src;
    large.alt = shown.alt;
    dialog.showModal();
  });
}
dialog.addEventListener("click", () => dialog.close());
