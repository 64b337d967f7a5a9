"use strict";
// Runs first: counts every error of the page, so that a test can read them off the root element.
const root = document.documentElement;
root.dataset.errors = "0";
function countError(error) {
  root.dataset.errors = String(Number(root.dataset.errors) + 1);
  root.dataset.lastError = String(error && error.message || error);
  console.error(error);
}
window.addEventListener("error", event => countError(event.error || event.message));
window.addEventListener("unhandledrejection", event => countError(event.reason));

